#include "turgor/pictures/run_scene.hpp"

#include <algorithm>
#include <future>
#include <optional>

#include <fmt/format.h>

#include "turgor/core/hash.hpp"
#include "turgor/pictures/finish_run.hpp"
#include "turgor/pictures/outputs.hpp"
#include "turgor/pictures/run_autosave.hpp"
#include "turgor/sim/live/haptic_replay.hpp"
#include "turgor/sim/recording/recording.hpp"
#include "turgor/sim/report/force_error.hpp"
#include "turgor/sim/report/lattice_warnings.hpp"
#include "turgor/sim/report/plausibility.hpp"
#include "turgor/sim/report/report_cloth.hpp"
#include "turgor/sim/report/report_organs.hpp"
#include "turgor/sim/report/report_texture.hpp"
#include "turgor/sim/report/report_touch.hpp"
#include "turgor/sim/run.hpp"
#include "turgor/sim/smooth_snapshot.hpp"
#include "turgor/view/drawing_process.hpp"
#include "turgor/view/video.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

void tell(const RunCallbacks& callbacks, const std::string& sentence) {
  if (callbacks.note && !sentence.empty()) callbacks.note(sentence);
}

void append(std::vector<std::string>& list, std::vector<std::string> more) {
  for (std::string& one : more) list.push_back(std::move(one));
}

Result<OutputFolder> open_folder(const Scene& scene, bool is_replay, const RunOptions& options,
                                 const RunCallbacks& callbacks) {
  Result<OutputFolder> folder = OutputFolder::create(
      options.out.empty() ? default_folder(scene.file, is_replay) : options.out, options.foreign);
  if (!folder) return folder;
  tell(callbacks, removed_foreign_note(*folder));
  for (const std::string& sentence : keep_haptic_logs(folder->goal())) tell(callbacks, sentence);
  return folder;
}

Status check_inputs(const Scene& scene, const OutputFolder& folder) {
  for (const LatticeScene& body : scene.lattice_bodies)
    for (const fs::path& input : {body.ct.file, body.labels, body.direction_field, body.fiber_field})
      if (const Status status = folder.check_input(input); !status) return status;
  return Done{};
}

/// Prepares the process that draws, while results are written.
std::future<void> warm_up(const Outputs& outputs) {
  const bool draws = std::any_of(outputs.views.begin(), outputs.views.end(),
                                 [](const SurfaceView& view) { return view.before_after; });
  return outputs.can_draw && draws ? warm_up_drawing() : std::future<void>();
}

/// A run that is being written to its folder.
struct FolderRun {
  const fs::path folder;
  const Exec& exec;
  const Scene& scene;
  World& world;
  Outputs& outputs;
  const RunCallbacks& callbacks;
  std::optional<RecordingWriter> recording;
  std::optional<LiveRun> live;
  std::unique_ptr<HapticReplay> replay;
  std::vector<ClothStretch> stretch;
  std::vector<WorldSnapshot> later;  // snapshots of a real-time run, written and drawn afterwards
  std::optional<Autosave> autosave;
};

/// Saves the run if it is time. A run whose state cannot be saved goes on without.
void autosave(FolderRun& run, const Timer& total, const Timer& simulation, const World& world,
              const Simulated& simulated) {
  if (!run.autosave->is_due()) return;
  RunFacts& facts = run.outputs.facts;
  const AddTime time(facts.file_seconds);
  const Status saved =
      run.autosave->save(world, {.simulated = const_cast<Simulated&>(simulated),  // save changes nothing
                                 .outputs = run.outputs,
                                 .stretch = run.stretch,
                                 .snapshots = run.recording ? run.recording->snapshot_count() : 0,
                                 .seconds = facts.resumed_after + total.seconds(),
                                 .simulation_seconds = facts.simulation_seconds + simulation.seconds()});
  if (saved) return;
  run.autosave->stop();
  facts.warnings.push_back("no further autosave: " + saved.error().message);
}

Status take_snapshot(FolderRun& run, const World& world, const WorldSnapshot& snapshot) {
  record_stretch(snapshot, run.stretch);
  Status status = Done{};
  if (run.live) {
    run.later.push_back(snapshot);
    for (BodySnapshot& body : run.later.back().bodies) body.cache.reset();
  } else {
    status = add_snapshot(snapshot, run.outputs);
  }
  if (status && run.recording) {
    const AddTime time(run.outputs.facts.file_seconds);
    status = run.recording->add_snapshot(world, snapshot);
  }
  if (status && !run.live) draw_frames(snapshot, run.outputs);  // its state is in the recording
  if (status && run.callbacks.snapshot) status = run.callbacks.snapshot(snapshot);
  return status;
}

Result<Simulated> simulate_into(FolderRun& run, const Timer& total, std::optional<Simulated> resumed,
                                WorldSnapshot first) {
  RunEvents events;
  if (run.callbacks.begin) events.progress = run.callbacks.begin("simulating", "");
  events.frame = run.callbacks.frame;
  if (run.live)
    events.frame = [&run](const World& world) {
      for (const std::string& sentence : run.live->touch->news()) tell(run.callbacks, sentence);
      run.live->touch->record_frame_inputs();
      run.live->touch->wait_for_frame();
      return !run.callbacks.frame || run.callbacks.frame(world);
    };
  Status replayed = run.replay ? run.replay->next_frame(run.exec) : Done{};
  if (run.replay)
    events.frame = [&run, &replayed](const World& world) {
      if (replayed) replayed = run.replay->next_frame(run.exec);
      return replayed && (!run.callbacks.frame || run.callbacks.frame(world));
    };
  events.snapshot = [&run](const World& w, const WorldSnapshot& snapshot) {
    return take_snapshot(run, w, snapshot);
  };
  events.picture = [&run](const WorldSnapshot& snapshot) {
    record_stretch(snapshot, run.stretch);
    take_moment(snapshot, run.outputs);
    return Status(Done{});
  };
  if (!run.live) events.wants_picture = [&run](const World& w) { return wants_moment(w, run.outputs); };
  const Timer timer;
  if (run.autosave)
    events.end_of_frame = [&](const World& world, const Simulated& simulated) -> Status {
      autosave(run, total, timer, world, simulated);
      return Done{};
    };
  Result<Simulated> done =
      simulate(run.exec, run.scene, run.world, events, std::move(resumed), std::move(first));
  if (run.live) run.live->touch->stop();
  if (run.replay) run.replay->end();
  if (!replayed) return replayed.error();
  run.outputs.facts.simulation_seconds += timer.seconds();
  return done;
}

/// Report of a replayed haptic run. A killed one has no state to compare with.
Json haptic_report(const HapticRecording& haptic, const World& world) {
  std::size_t ticks = 0;
  for (const HapticTool& tool : haptic.tools) ticks += tool.ticks.size();
  Json json{{"frames", haptic.frames}, {"ticks", ticks}};
  if (!haptic.has_hash) return json;
  json["state_hash"] = hash_text(haptic.hash);
  json["same_bits"] = state_hash(world) == haptic.hash;
  return json;
}

/// Writes the data for `turgor replay`.
Status write_haptics(FolderRun& run) {
  if (!run.live) return Done{};
  Result<HapticRecording> haptic = run.live->touch->haptic_recording();
  if (!haptic) return haptic.error();
  set_scene(run.scene, false, *haptic);
  const Status written = write_haptic_recording(run.folder / "haptic.h5", *haptic);
  if (written) run.outputs.facts.files.push_back("haptic.h5");
  return written;
}

/// Report of the simulation; also stored in the recording.
Result<Json> report_of(FolderRun& run, const Simulated& done) {
  RunFacts& facts = run.outputs.facts;
  facts.drawing_seconds += done.show_seconds;
  if (const Status haptic = write_haptics(run); !haptic) facts.warnings.push_back(haptic.error().message);
  // warnings
  if (!done.stopped.empty()) facts.warnings.push_back(done.stopped);
  append(facts.warnings, cloth_warnings(run.world));
  append(facts.warnings, overstretched(run.stretch));
  append(facts.warnings, touch_warnings(run.world));
  append(facts.warnings, texture_warnings(run.world));
  append(facts.warnings, device_warnings(run.scene, run.world));
  append(facts.warnings, coupling_warnings(run.world));
  append(facts.warnings, force_error_warnings(run.world));
  append(facts.warnings, overpressed(run.world, done.measures.pressed));
  append(facts.warnings, overstrained(run.world));
  append(facts.warnings, lattice_warnings(run.exec, run.world));
  if (run.live) append(facts.warnings, haptics_warnings(*run.live));
  // report
  Json report = simulation_report(run.exec, run.scene, run.world, done.measures, facts);
  report["warnings"] = facts.warnings;  // for a replay
  if (run.live) report["haptics"] = haptics_report(*run.live);
  if (run.replay) report["haptic_replay"] = haptic_report(run.replay->run(), run.world);
  if (!done.stopped.empty()) report["stopped"] = done.stopped, report["finite"] = done.finite;
  // recording
  if (!run.recording) return report;
  const AddTime time(facts.file_seconds);
  const Status status =
      run.recording->finish(run.world, done.snapshot, done.measures.pressed, json_text(report, -1));
  run.recording.reset();
  if (!status) return status.error();
  facts.files.push_back("recording.h5");
  return report;
}

/// Chooses the motion of the tools: a haptic device, a haptic recording, or, if neither is given, their
/// paths.
Status begin_touch(const RunOptions& options, std::optional<HapticRecording> haptic, const fs::path& goal,
                   FolderRun& run) {
  if (options.live) {
    LiveOptions with_limits = *options.live;
    for (const ToolScene& tool : run.scene.tools)
      if (with_limits.tool.empty() ? &tool == &run.scene.tools[0] : tool.name == with_limits.tool)
        with_limits.limits = tool.device;
    Result<LiveRun> live = start_live(run.world, with_limits, run.scene.duration);
    if (!live) return live.error();
    run.live.emplace(std::move(*live));
    run.live->touch->begin_log(goal, run.scene);
  }
  if (haptic) {
    Result<std::unique_ptr<HapticReplay>> replay = HapticReplay::begin(run.world, std::move(*haptic));
    if (!replay) return replay.error();
    run.replay = std::move(*replay);
  }
  return Done{};
}

/// Begins the recording, or continues that of the autosave.
Status begin_recording(FolderRun& run, const UnfinishedRun* unfinished) {
  if (!run.scene.output.recording) return Done{};
  const fs::path file = run.folder / "recording.h5";
  Result<RecordingWriter> writer = unfinished ? RecordingWriter::resume(file, unfinished->snapshots)
                                              : RecordingWriter::create(file, run.scene, run.world);
  if (!writer) return writer.error();
  run.recording.emplace(std::move(*writer));
  return Done{};
}

/// A run, and the autosave that it goes on from.
struct RunStart {
  const RunOptions& options;
  std::optional<HapticRecording> haptic;
  std::optional<SavedRun> saved;
};

/// Restores an autosave into the loaded world and the new outputs, and starts the next autosaves. Returns the
/// result so far of a resumed run.
Result<std::optional<Simulated>> begin_autosave(const fs::path& goal, RunStart& start, FolderRun& run) {
  const bool can_save = !start.options.live && !start.haptic;
  if (can_save)
    run.autosave.emplace(start.saved ? std::move(start.saved->folder) : AutosaveFolder(goal),
                         start.options.autosave_interval, run.scene, run.world);
  if (!start.saved) {
    if (const Status begun = begin_recording(run, nullptr); !begun) return begun.error();
    return std::optional<Simulated>();
  }
  Simulated simulated;
  UnfinishedRun unfinished{.simulated = simulated, .outputs = run.outputs, .stretch = run.stretch};
  Status status = run.autosave->restore(run.exec, *start.saved, run.world, unfinished);
  if (status) status = begin_recording(run, &unfinished);
  start.saved.reset();  // the file is as large as the world
  if (!status) return status.error();
  run.outputs.facts.resumed_after = unfinished.seconds;
  run.outputs.facts.simulation_seconds = unfinished.simulation_seconds;
  return std::optional(std::move(simulated));
}

/// Runs in the open folder.
Result<Json> run_into(const Exec& exec, const Scene& scene, const Timer& total, OutputFolder& folder,
                      RunStart start, const RunCallbacks& callbacks) {
  Result<World> world = load_world(exec, scene, callbacks.begin);
  if (!world) return world.error();
  WorldSnapshot first;
  show(exec, *world, first);
  show_smooth(first);
  Result<Outputs> outputs = make_outputs(exec, scene, *world, first, folder.path());
  if (!outputs) return outputs.error();
  outputs->facts.load_seconds = total.seconds();
  append(outputs->facts.warnings, notes_of(*world));
  append(outputs->facts.warnings, odd_sizes(first));
  FolderRun run{folder.path(), exec,         scene, *world, *outputs, callbacks,
                std::nullopt,  std::nullopt, {},    {},     {},       std::nullopt};
  Result<std::optional<Simulated>> resumed = begin_autosave(folder.goal(), start, run);
  if (!resumed) return resumed.error();
  if (const Status begun = begin_touch(start.options, std::move(start.haptic), folder.goal(), run); !begun)
    return begun.error();
  const Result<Simulated> done = simulate_into(run, total, std::move(*resumed), std::move(first));
  if (!done) return done.error();
  Result<Json> report = report_of(run, *done);
  if (!report) return report.error();
  if (scene.output.video && !has_ffmpeg())
    outputs->facts.warnings.push_back("no video: ffmpeg is not on the PATH (Debian: apt-get install ffmpeg)");
  const FinishedRun finished{*world, done->snapshot, done->measures.pressed, run.later, *outputs};
  const std::future<void> drawing = warm_up(*outputs);
  Status status = Done{};
  for (std::size_t s = 0; s < run.later.size() && status; s++) status = add_snapshot(run.later[s], *outputs);
  if (status) status = commit_results(total, finished, *report, folder, callbacks);
  if (status && run.autosave) run.autosave->remove();
  if (status && run.live) run.live->touch->log()->remove();
  if (status) status = add_pictures_to_results(total, finished, *report, folder, callbacks);
  return status ? report : status.error();
}

/// Replays in the open folder.
Result<Json> replay_into(const Exec& exec, const Recording& recording, const Scene& scene, const Timer& total,
                         OutputFolder& folder, const RunCallbacks& callbacks) {
  Result<World> world = load_world(exec, scene, callbacks.begin, Purpose::kDraw);
  if (!world) return world.error();
  WorldSnapshot snapshot;
  snapshot.cutaway = scene.look.cutaway;
  std::vector<Pressed> pressed;
  Status status = recording.check_world(*world);
  if (status) status = recording.restore(exec, 0, *world, snapshot);
  if (status) status = recording.restore_touch(*world, pressed);
  if (!status) return status.error();
  Json report = Json::parse(recording.report(), nullptr, false);
  if (!report.is_object() || !report.contains("timing"))
    return Error{recording.path().string() + ": the recorded report is damaged"};
  Result<Outputs> outputs = make_outputs(exec, scene, *world, snapshot, folder.path());
  if (!outputs) return outputs.error();
  const Progress progress = begin_work(callbacks.begin, "replaying");
  for (int s = 0; s < recording.snapshot_count() && status; s++) {
    status = recording.restore(exec, s, *world, snapshot);
    if (status) status = add_snapshot(snapshot, *outputs);
    if (status) draw_frames(snapshot, *outputs), take_moment(snapshot, *outputs);
    if (status && callbacks.snapshot) status = callbacks.snapshot(snapshot);
    if (progress) progress(double(s + 1) / recording.snapshot_count());
  }
  report["replayed_from"] = recording.path().string();
  for (const Json& warning : report.value("warnings", Json::array()))  // earlier recordings have none
    if (warning.is_string()) outputs->facts.warnings.push_back(warning);
  const std::vector<WorldSnapshot> no_later;
  const FinishedRun finished{*world, snapshot, pressed, no_later, *outputs};
  const std::future<void> drawing = warm_up(*outputs);
  if (status) status = commit_results(total, finished, report, folder, callbacks);
  if (status) status = add_pictures_to_results(total, finished, report, folder, callbacks);
  return status ? Result<Json>(std::move(report)) : status.error();
}

}  // namespace

fs::path default_folder(const fs::path& scene_file, bool is_replay) {
  return fs::path("out") / (scene_file.stem().string() + (is_replay ? "-replay" : ""));
}

Result<Json> run_scene(const Exec& exec, const Scene& scene, const RunOptions& options,
                       const RunCallbacks& callbacks) {
  const Timer total;
  Result<OutputFolder> folder = open_folder(scene, false, options, callbacks);
  if (!folder) return folder.error();
  if (const Status status = check_inputs(scene, *folder); !status) return status.error();
  Result<std::optional<SavedRun>> saved =
      choose_saved_run(folder->goal(), scene, options.resume, callbacks.note);
  if (!saved) return saved.error();
  return run_into(exec, scene, total, *folder, {options, std::nullopt, std::move(*saved)}, callbacks);
}

Result<Json> replay_haptic_run(const Exec& exec, const fs::path& file, const RunOptions& options,
                               const RunCallbacks& callbacks) {
  const Timer total;
  Result<HapticRecording> haptic = read_haptic_recording(file);
  if (!haptic) return haptic.error();
  const Result<Scene> scene = scene_of(*haptic);
  if (!scene) return Error{fmt::format("{}: {}", file.string(), scene.error().message)};
  Result<OutputFolder> folder = open_folder(*scene, true, options, callbacks);
  if (!folder) return folder.error();
  Status status = check_inputs(*scene, *folder);
  if (status) status = folder->check_input(file);
  if (!status) return status.error();
  return run_into(exec, *scene, total, *folder, {options, std::move(*haptic), std::nullopt}, callbacks);
}

Result<Json> replay_recording(const Exec& exec, const fs::path& file,
                              const std::vector<std::string>& overrides, const RunOptions& options,
                              const RunCallbacks& callbacks) {
  const Timer total;
  const Result<Recording> recording = Recording::open(file);
  if (!recording) return recording.error();
  const Result<Scene> scene = recording->scene(overrides);
  if (!scene) return scene.error();
  Result<OutputFolder> folder = open_folder(*scene, true, options, callbacks);
  if (!folder) return folder.error();
  if (const Status status = folder->check_input(file); !status) return status.error();
  return replay_into(exec, *recording, *scene, total, *folder, callbacks);
}

}  // namespace turgor
