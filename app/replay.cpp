// `turgor replay`: repeats a recorded haptic run without a device and without a clock, and checks that the
// state has the same bits. The library does the work (pictures/run_scene.hpp).
#include <filesystem>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/commands.hpp"
#include "app/print.hpp"
#include "app/result_folder.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/pictures/run_scene.hpp"
#include "turgor/sim/report/summary.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

struct ReplayOptions {
  fs::path file, out;
  bool quiet = false, force = false;
};

void replay(const Exec& exec, const ReplayOptions& options) {
  std::optional<ProgressBar> bar;
  RunCallbacks callbacks;
  callbacks.note = [](const std::string& sentence) { note(sentence); };
  if (!options.quiet)
    callbacks.begin = [&bar](const std::string& label, const std::string&) {
      bar.reset();
      bar.emplace(label);
      return bar->callback();
    };
  const fs::path out = options.out.empty() ? default_folder(options.file, true) : options.out;
  const RunOptions goal{.out = out, .foreign = options.force ? Foreign::kRemove : Foreign::kRefuse};
  const Json report = required(replay_haptic_run(exec, options.file, goal, callbacks));
  bar.reset();
  if (!options.quiet) print_text(summary_text(report, required(resolved_goal(out))));
  const Json& haptic = report.at("haptic_replay");
  if (!haptic.contains("same_bits")) {
    print_plain("{} frames and {} ticks; the run was interrupted, so there is no state to compare with\n",
                haptic.at("frames").get<int>(), haptic.at("ticks").get<long>());
    return;
  }
  const bool same = haptic.at("same_bits").get<bool>();
  const std::string outcome =
      fmt::format("{} frames and {} ticks gave {} state {}", haptic.at("frames").get<int>(),
                  haptic.at("ticks").get<long>(), same ? "the same" : "a different",
                  haptic.at("state_hash").get<std::string>());
  if (!same) throw Failure{kNotFinite, outcome + ": another machine, compiler or version rounds differently"};
  print_plain("{}\n", outcome);
}

}  // namespace

void add_replay_command(CLI::App& program, Global& global) {
  auto options = std::make_shared<ReplayOptions>();
  CLI::App* command =
      program.add_subcommand("replay", "Repeat a haptic recording bit for bit, without device or clock");
  command->footer(
      "Examples:\n"
      "  turgor replay out/palpation/haptic.h5              of turgor run --real-time\n"
      "  turgor replay out/view/palpation-haptic-1.h5       of turgor view, key H\n"
      "  turgor replay out/palpation.haptic-log             the log of an interrupted run\n"
      "Exit code 3: the state has other bits. turgor run --replay redraws a recording.");
  command->add_option("file", options->file, "The haptic recording: an .h5 file, or a .haptic-log")
      ->required();
  command->add_option("-o,--out", options->out, "Folder for the results (default: out/NAME-replay)");
  add_force_option(*command, options->force);
  command->add_flag("-q,--quiet", options->quiet, "No progress bar and no table");
  command->callback([options, &global] { replay(Exec(global.threads), *options); });
}

}  // namespace turgor
