// `turgor run`: simulates a scene, or draws a recording again, into a folder that appears when it is
// complete.
#include <cstdio>
#include <filesystem>
#include <optional>

#include <fmt/format.h>

#include "app/commands.hpp"
#include "app/outputs.hpp"
#include "app/result_folder.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/io/file.hpp"
#include "turgor/sim/recording/recording.hpp"
#include "turgor/sim/report/report_cloth.hpp"
#include "turgor/sim/report/report_touch.hpp"
#include "turgor/sim/report/summary.hpp"
#include "turgor/view/video.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

struct RunOptions {
  fs::path scene, out, replay;
  std::vector<std::string> overrides;
  bool quiet = false, force = false;
};

/// The value, or the end of the command.
template <class T>
T required(Result<T> result) {
  if (!result) throw Failure{2, result.error().message};
  return std::move(*result);
}

/// A bar that a quiet run does not show.
class OptionalBar {
 public:
  OptionalBar(const RunOptions& options, const char* label) {
    if (!options.quiet) bar_.emplace(label);
  }
  Progress callback() { return bar_ ? bar_->callback() : Progress(); }
  void update(double fraction) {
    if (bar_) bar_->update(fraction);
  }

 private:
  std::optional<ProgressBar> bar_;
};

/// Work that takes long is announced by a sentence and gets a bar of its own.
World load(const Exec& exec, const Scene& scene, const RunOptions& options,
           Purpose purpose = Purpose::kSimulate) {
  std::optional<OptionalBar> bar;
  const BeginWork begin = [&](const std::string& label, const std::string& sentence) {
    bar.reset();
    if (!options.quiet && !sentence.empty()) fmt::print("{}\n", sentence);
    bar.emplace(options, label.c_str());
    return bar->callback();
  };
  return required(load_world(exec, scene, begin, purpose));
}

/// A snapshot goes into pictures and meshes, and into the recording when there is one.
void snapshot(World& world, Outputs& outputs, std::optional<RecordingWriter>& recording) {
  show_touched(*outputs.exec, world);
  required(add_snapshot(world, outputs));
  if (recording) required(recording->add_snapshot(world));
}

/// Returns the seconds spent in the frames themselves.
Measures simulate(const Exec& exec, const Scene& scene, World& world, Outputs& outputs,
                  std::optional<RecordingWriter>& recording, const RunOptions& options) {
  Measures measures = make_measures(world);
  OptionalBar bar(options, "simulating");
  const int frames = frame_count(scene), interval = video_interval(outputs);
  snapshot(world, outputs, recording);
  for (int frame = 1; frame <= frames; frame++) {
    const bool shown = is_snapshot(scene, frame);
    const FrameReport report = required(step(exec, world, shown));
    measure_frame(exec, world, report, shown || !report.finite, measures);
    if (!report.finite) {
      outputs.facts.stopped = fmt::format(
          "stopped after {:.3f} s of {} s: the numbers of the next step were not finite, the state before it "
          "was kept; a smaller skin tension or a higher frame rate may help",
          time_of(world), scene.duration);
      outputs.facts.warnings.push_back(outputs.facts.stopped);
      snapshot(world, outputs, recording);
      break;
    }
    if (interval > 0 && frame % interval == 0) {
      show_touched(exec, world);
      required(add_video_frame(world, outputs));
    }
    if (shown) snapshot(world, outputs, recording);
    bar.update(double(frame) / frames);
  }
  return measures;
}

void write_report(const Json& report, const fs::path& folder) {
  required(write_file(folder / "report.html", report_html(report, folder)));
  required(write_file(folder / kReportFile, json_text(report) + "\n"));
}

void finish(const Timer& total, const Timer& output, const World& world, Outputs& outputs, Json& report,
            OutputFolder& folder, const RunOptions& options) {
  required(finish_outputs(world, outputs));
  outputs.facts.output_seconds = output.seconds();
  outputs.facts.total_seconds = total.seconds();
  add_outputs(report, outputs.facts);
  write_report(report, folder.path());
  commit_results(folder);
  if (!options.quiet) fmt::print("{}", summary_text(report, folder.goal()));
}

fs::path default_folder(const Scene& scene, const char* ending) {
  return fs::path("out") / (scene.file.stem().string() + ending);
}

void run(const Exec& exec, const RunOptions& options) {
  const Timer total;
  const Scene scene = required(read_scene(options.scene, options.overrides));
  OutputFolder folder =
      open_result_folder(options.out.empty() ? default_folder(scene, "") : options.out, options.force);
  for (const LatticeScene& body : scene.lattice_bodies)
    for (const fs::path& input : {body.ct.file, body.labels, body.direction_field})
      required(folder.check_input(input));
  World world = load(exec, scene, options);
  show_touched(exec, world);
  Outputs outputs = required(make_outputs(exec, scene, world, folder.path()));
  outputs.facts.load_seconds = total.seconds();
  for (const LatticeBody& body : world.lattice_bodies)
    for (const std::string& note : body.notes) outputs.facts.warnings.push_back(body.name + ": " + note);
  for (const SfemBody& body : world.sfem_bodies)
    for (const std::string& note : body.facts.notes)
      outputs.facts.warnings.push_back(body.name + ": " + note);

  for (const RhombusBody& body : world.rhombus_bodies)
    for (const std::string& note : body.notes) outputs.facts.warnings.push_back(body.name + ": " + note);
  for (const ClothBody& body : world.cloth_bodies)
    for (const std::string& note : body.notes) outputs.facts.warnings.push_back(body.name + ": " + note);

  if (scene.output.video && !has_ffmpeg())
    outputs.facts.warnings.push_back("no video: ffmpeg is not on the PATH (Debian: apt-get install ffmpeg)");
  std::optional<RecordingWriter> recording;
  if (scene.output.recording)
    recording.emplace(required(RecordingWriter::create(folder.path() / "recording.h5", scene, world)));
  const Timer simulation;
  const Measures measures = simulate(exec, scene, world, outputs, recording, options);
  outputs.facts.simulation_seconds = simulation.seconds();
  for (std::string& warning : cloth_warnings(world)) outputs.facts.warnings.push_back(std::move(warning));
  for (std::string& warning : touch_warnings(world)) outputs.facts.warnings.push_back(std::move(warning));
  Json report = simulation_report(exec, scene, world, measures, outputs.facts);
  if (recording) {
    required(recording->finish(world, json_text(report, -1)));
    recording.reset();
    outputs.facts.files.push_back("recording.h5");
  }
  finish(total, Timer(), world, outputs, report, folder, options);
  if (!outputs.facts.stopped.empty())
    throw Failure{kNotFinite, fmt::format("{}: {}", options.scene.string(), outputs.facts.stopped)};
}

void replay(const Exec& exec, const RunOptions& options) {
  const Timer total;
  const Recording recording = required(Recording::open(options.replay));
  const Scene scene = required(recording.scene(options.overrides));
  OutputFolder folder =
      open_result_folder(options.out.empty() ? default_folder(scene, "-replay") : options.out, options.force);
  required(folder.check_input(options.replay));
  World world = load(exec, scene, options, Purpose::kDraw);
  required(recording.check_world(world));
  required(recording.restore(0, world));
  required(recording.restore_touch(world));
  Json report = Json::parse(recording.report(), nullptr, false);
  if (!report.is_object() || !report.contains("timing"))
    throw Failure{2, options.replay.string() + ": the recorded report is damaged"};
  Outputs outputs = required(make_outputs(exec, scene, world, folder.path()));
  OptionalBar bar(options, "drawing");
  for (int s = 0; s < recording.snapshot_count(); s++) {
    required(recording.restore(s, world));
    required(add_snapshot(world, outputs));
    bar.update(double(s + 1) / recording.snapshot_count());
  }
  report["replayed_from"] = options.replay.string();
  finish(total, Timer(), world, outputs, report, folder, options);
}

}  // namespace

void add_run_command(CLI::App& program, Global& global) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* command =
      program.add_subcommand("run", "Simulate a scene without a window: pictures, measures, a report");
  command->footer(
      "Examples:\n"
      "  turgor run scenes/incision.toml --out out/incision\n"
      "  turgor run scenes/incision.toml --set body.torso.ct=patient.nii.gz --set "
      "body.torso.skin.tension=60\n"
      "  turgor run --replay out/incision/recording.h5 --set output.color=stretch --out out/again\n"
      "All keys of a scene are listed in docs/scene.md.");
  command->add_option("scene", options->scene, "The scene, a TOML file");
  command->add_option("-o,--out", options->out, "Folder for the results (default: out/SCENE)");
  command
      ->add_option("--set", options->overrides,
                   "key=value: overrides a key of the scene, key= removes it; may be repeated")
      ->type_size(1)
      ->allow_extra_args(false);
  command->add_option("--replay", options->replay, "Draw this recording.h5 again instead of simulating");
  add_force_option(*command, options->force);
  command->add_flag("-q,--quiet", options->quiet, "No progress bar and no table");
  command->callback([options, &global] {
    if (options->scene.empty() == options->replay.empty())
      throw Failure{2, "run: expected either a scene or --replay FILE; see turgor run --help"};
    const Exec exec(global.threads);
    options->replay.empty() ? run(exec, *options) : replay(exec, *options);
  });
}

}  // namespace turgor
