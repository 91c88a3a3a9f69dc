// A whole run into a folder: what `turgor run` does, for every program that links the library. The folder
// appears when it is complete (sim/output_folder.hpp).
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
  std::optional<LiveOptions> live;  // in real time, with a hand
};

/// What a run tells while it goes on; any of them may be empty.
struct RunCallbacks {
  BeginWork begin;                                       // before work that takes long: a bar and a sentence
  std::function<void(const std::string&)> note;          // remarks about others' files in the folder
  std::function<bool(const World&)> frame;               // after every frame; false ends the run there
  std::function<Status(const WorldSnapshot&)> snapshot;  // as the world looks; its failure ends the run
};

/// Where results go unless one says it: "out/NAME" of a scene file NAME.toml, of a replay "out/NAME-replay".
std::filesystem::path default_folder(const std::filesystem::path& scene_file, bool is_replay);

/// Loads, simulates, measures, draws and writes; returns the report. One that ended early has "stopped", a
/// sentence, and "finite" false when its numbers were the reason. Error: nothing is left behind.
Result<Json> run_scene(const Exec& exec, const Scene& scene, const RunOptions& options,
                       const RunCallbacks& callbacks = {});

/// Does a felt run again and leaves what run_scene leaves. The report has "felt": frames, ticks, the state's
/// hash then, and whether it is that now, bit for bit. Error: the file is no felt run, or as run_scene.
Result<Json> replay_felt_run(const Exec& exec, const std::filesystem::path& file, const RunOptions& options,
                             const RunCallbacks& callbacks = {});

/// Draws a recording again; `overrides` may say what to draw and where the CT is now.
Result<Json> replay_recording(const Exec& exec, const std::filesystem::path& file,
                              const std::vector<std::string>& overrides, const RunOptions& options,
                              const RunCallbacks& callbacks = {});

}  // namespace turgor
