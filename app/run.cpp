// `turgor run`: simulates a scene, or redraws a recording, into a folder that appears when it is complete.
// The library does the work (pictures/run_scene.hpp); this file has the options, progress bars and summary.
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/check_scene.hpp"
#include "app/commands.hpp"
#include "app/print.hpp"
#include "app/result_folder.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/pictures/run_scene.hpp"
#include "turgor/sim/report/require.hpp"
#include "turgor/sim/report/summary.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

struct CommandOptions {
  fs::path scene, out, replay;
  std::vector<std::string> overrides, required;
  bool quiet = false, tells_progress = false, force = false, real_time = false, check = false, resume = false;
  double autosave = 60;  // [s]
  LiveOptions live;
};

/// Prints a line per percent on standard error, for programs that parse it: "simulating 0.42".
Progress progress_lines(const std::string& label) {
  return [label, last = std::make_shared<std::atomic<int>>(-1)](double fraction) {
    const int percent = int(100 * fraction);
    if (last->exchange(percent) != percent) print_plain(stderr, "{} {:.2f}\n", label, fraction);
  };
}

/// Callbacks of the run. Long work is announced by a sentence and gets its own bar, unless the run is quiet.
RunCallbacks make_callbacks(const CommandOptions& options, std::optional<ProgressBar>& bar) {
  RunCallbacks callbacks;
  callbacks.note = [](const std::string& sentence) { note(sentence); };
  if (options.tells_progress)
    callbacks.begin = [](const std::string& label, const std::string&) { return progress_lines(label); };
  if (options.quiet || options.tells_progress) return callbacks;
  callbacks.begin = [&bar](const std::string& label, const std::string& sentence) {
    bar.reset();
    if (!sentence.empty()) print_plain("{}\n", sentence);
    bar.emplace(label);
    return bar->callback();
  };
  return callbacks;
}

/// Result folder of the run.
fs::path goal_of(const CommandOptions& options, const Json& report) {
  const fs::path scene = report.at("scene").at("file").get<std::string>();
  return required(
      resolved_goal(options.out.empty() ? default_folder(scene, !options.replay.empty()) : options.out));
}

/// Refuses an option of one driver if another one is chosen, which would ignore it.
void check_driver(const CLI::Option& option, const std::string& driver, const std::string& chosen) {
  if (option.count() == 0 || chosen == driver) return;
  throw Failure{2, fmt::format("run: {} is an option of --device {}: expected that device, found --device {}",
                               option.get_name(), driver, on_one_line(chosen))};
}

void run(const Exec& exec, const CommandOptions& options) {
  RunOptions goal{.out = options.out,
                  .foreign = options.force ? Foreign::kRemove : Foreign::kRefuse,
                  .live = std::nullopt,
                  .autosave_interval = options.autosave,
                  .resume = options.resume};
  if (options.real_time) goal.live = options.live;
  std::vector<Requirement> requirements;
  for (const std::string& text : options.required) requirements.push_back(required(read_requirement(text)));
  if (options.check) return check_scene(exec, required(read_scene(options.scene, options.overrides)));
  std::optional<ProgressBar> bar;
  const RunCallbacks callbacks = make_callbacks(options, bar);
  const Json report =
      options.replay.empty()
          ? required(run_scene(exec, required(read_scene(options.scene, options.overrides)), goal, callbacks))
          : required(replay_recording(exec, options.replay, options.overrides, goal, callbacks));
  bar.reset();
  if (!options.quiet) print_text(summary_text(report, goal_of(options, report)));
  if (options.replay.empty() && !report.value("finite", true))
    throw Failure{kNotFinite,
                  fmt::format("{}: {}", options.scene.string(), report.at("stopped").get<std::string>())};
  for (const Requirement& requirement : requirements)
    if (const std::string missed = required(missed_by(report, requirement)); !missed.empty())
      throw Failure{kNotFinite, missed};
}

}  // namespace

void add_run_command(CLI::App& program, Global& global) {
  auto options = std::make_shared<CommandOptions>();
  CLI::App* command = program.add_subcommand(
      "run", "Simulate a scene without a window; writes pictures, measures and a report");
  command->footer(
      "Examples:\n"
      "  turgor run scenes/incision.toml --out out/incision\n"
      "  turgor run scenes/incision.toml --set body.torso.ct=patient.nii.gz --set "
      "body.torso.skin.tension=60\n"
      "  turgor run --replay out/incision/recording.h5 --set output.color=stretch --out out/again\n"
      "  turgor run scenes/drape.toml --check\n"
      "  turgor run scenes/drape.toml --out out/drape --resume    after the same run was interrupted\n"
      "  turgor run scenes/palpation.toml --real-time --require \"haptics.missed<0.001\"\n"
      "docs/scene.md lists all keys of a scene.");
  command->add_option("scene", options->scene, "The scene, a TOML file");
  command->add_option("-o,--out", options->out, "Folder for the results (default: out/SCENE)");
  add_set_option(*command, options->overrides);
  command->add_option("--replay", options->replay, "Redraw this recording.h5 instead of simulating");
  CLI::Option* check =
      command->add_flag("--check", options->check,
                        "Load the scene, step a few frames and print the cost of a run; writes no files");
  CLI::Option* resume =
      command->add_flag("--resume", options->resume,
                        "Continue an interrupted run of the same scene and folder from its latest autosave");
  CLI::Option* autosave = command->add_option("--autosave", options->autosave,
                                              "Wall time between autosaves [s]; 0: none (default: 60)");
  autosave->check(number_within(0, 86400, "s"));
  command->add_flag("--real-time", options->real_time,
                    "Run in real time with a haptic loop: a device controls a tool of the scene");
  CLI::Option* device = command->add_option(
      "--device", options->live.device,
      "With --real-time: a driver of turgor devices (default: virtual, needs no hardware)");
  CLI::Option* tool =
      command->add_option("--tool", options->live.tool,
                          "With --real-time: the tool that the device controls (default: the first)");
  CLI::Option* rate = command->add_option("--rate", options->live.rate,
                                          "With --real-time: rate of the haptic loop [Hz] (default: 1000)");
  rate->check(number_within(100, 10000, "Hz"));
  CLI::Option* file = command->add_option("--device-file", options->live.driver.file,
                                          "With --device replay: the .csv of poses (docs/devices.md)");
  CLI::Option* address = command->add_option("--device-address", options->live.driver.address,
                                             "With --device inverse3: HOST:PORT of its service");
  address->capture_default_str();
  for (CLI::Option* option : {device, tool, rate, file, address})
    option->needs(command->get_option("--real-time"));
  for (const char* other : {"--replay", "--check", "--real-time"}) {
    resume->excludes(command->get_option(other));
    autosave->excludes(command->get_option(other));
  }
  command
      ->add_option("--require", options->required,
                   "Condition on a number of report.json, such as \"haptics.missed<0.001\"; exit code 3 if "
                   "it fails; may "
                   "be repeated")
      ->type_size(1)
      ->allow_extra_args(false);
  for (const char* other : {"--replay", "--real-time", "--require"})
    check->excludes(command->get_option(other));
  add_force_option(*command, options->force);
  command->add_flag("-q,--quiet", options->quiet, "Print no progress bar and no table");
  command->add_flag("--progress", options->tells_progress,
                    "Print progress lines for programs instead of a bar: simulating 0.42");
  command->callback([options, file, address, &global] {
    if (options->scene.empty() == options->replay.empty())
      throw Failure{2, "run: expected either a scene or --replay FILE; see turgor run --help"};
    if (options->real_time && options->scene.empty())
      throw Failure{2, "run: --real-time needs a scene; a recording has no simulated bodies"};
    check_driver(*file, "replay", options->live.device);
    check_driver(*address, "inverse3", options->live.device);
    run(Exec(global.threads), *options);
  });
}

}  // namespace turgor
