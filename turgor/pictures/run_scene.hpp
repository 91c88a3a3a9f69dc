// A complete run into a folder: the implementation of `turgor run` for every program that links the library.
// The folder appears when all results but the pictures are complete (finish_run.hpp, sim/output_folder.hpp).
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/sim/live/haptic_recording.hpp"
#include "turgor/sim/live/live_run.hpp"
#include "turgor/sim/loading.hpp"
#include "turgor/sim/output_folder.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/snapshot.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

struct RunOptions {
  std::filesystem::path out;  // empty: default_folder
  Foreign foreign = Foreign::kRefuse;
  std::optional<LiveOptions> live;  // in real time, with a haptic device
  double autosave_interval = 0;     // wall time between autosaves, not in real time; 0 = none [s]
  bool resume = false;              // goes on from the autosave of a killed run, if there is one
};

/// Callbacks of a run; any may be empty.
struct RunCallbacks {
  BeginWork begin;                                       // before a long task: a progress bar and a sentence
  std::function<void(const std::string&)> note;          // about foreign files in the folder, or lost devices
  std::function<bool(const World&)> frame;               // after every frame; false ends the run
  std::function<Status(const WorldSnapshot&)> snapshot;  // current snapshot; an error ends the run
};

/// Default folder of results: "out/NAME" for a scene file NAME.toml, "out/NAME-replay" for a replay.
std::filesystem::path default_folder(const std::filesystem::path& scene_file, bool is_replay);

/// Loads, simulates, measures, draws and writes; returns the report. A run that ended early has "stopped", a
/// sentence, and "finite" false if its numbers were the reason. After an error no folder remains, but an
/// autosave does; after an error of drawing, the results without pictures remain.
Result<Json> run_scene(const Exec& exec, const Scene& scene, const RunOptions& options,
                       const RunCallbacks& callbacks = {});

/// Replays a haptic run and writes the outputs of run_scene. The report has the recorded frames, ticks and
/// state hash, and whether the hash is bit-identical now. Error: the file is not a haptic recording, or as in
/// run_scene.
Result<Json> replay_haptic_run(const Exec& exec, const std::filesystem::path& file, const RunOptions& options,
                               const RunCallbacks& callbacks = {});

/// Draws a recording again; `overrides` may set the pictures and the current path of the CT.
Result<Json> replay_recording(const Exec& exec, const std::filesystem::path& file,
                              const std::vector<std::string>& overrides, const RunOptions& options,
                              const RunCallbacks& callbacks = {});

}  // namespace turgor
