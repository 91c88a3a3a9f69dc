// Autosaves of a run that writes to a folder: its world, its measures and its unfinished outputs, so that a
// killed run goes on from the latest one and ends with the same bits (sim/autosave/).
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "turgor/core/timing.hpp"
#include "turgor/pictures/outputs.hpp"
#include "turgor/sim/autosave/autosave_folder.hpp"
#include "turgor/sim/autosave/world_file.hpp"
#include "turgor/sim/recording/recording.hpp"
#include "turgor/sim/report/plausibility.hpp"
#include "turgor/sim/run.hpp"

namespace turgor {

/// State of an unfinished run besides its world.
struct UnfinishedRun {
  Simulated& simulated;
  Outputs& outputs;
  std::vector<ClothStretch>& stretch;
  int snapshots = 0;              // in the recording
  double seconds = 0;             // wall time so far
  double simulation_seconds = 0;  // of them in simulate()
};

/// An autosave that a run goes on from. Its header was compared with the scene.
struct SavedRun {
  AutosaveFolder folder;
  StateReader state;
  double time = 0;                // simulated time [s]
  std::uint64_t loaded_hash = 0;  // of the world after loading
};

/// Newest autosave of an ended run with this goal; empty if no autosave exists. Error: it is damaged, or of
/// another scene or version.
Result<std::optional<SavedRun>> find_saved_run(const std::filesystem::path& goal, const Scene& scene);

/// The same if a run resumes. Otherwise, and without an autosave, it tells so by a note.
Result<std::optional<SavedRun>> choose_saved_run(const std::filesystem::path& goal, const Scene& scene,
                                                 bool resume,
                                                 const std::function<void(const std::string&)>& note);

class Autosave {
 public:
  /// Saves about every `interval` seconds of wall time, 0 = never. From 1 s on, saves take at most a
  /// twentieth of the time.
  Autosave(AutosaveFolder folder, double interval, const Scene& scene, const World& loaded);

  /// Restores the loaded world and the new outputs; the folder is that of `saved`. Error: the world was
  /// loaded from other inputs, or the autosave is damaged.
  Status restore(const Exec& exec, SavedRun& saved, World& world, UnfinishedRun& run);

  bool is_due() const { return interval_ > 0 && since_.seconds() >= next_; }
  /// Saves a run after a frame, and does not change it. Error: the disk is full; the earlier autosave stays.
  Status save(const World& world, UnfinishedRun run);
  /// Stops saving, after an error.
  void stop() { interval_ = 0; }
  /// Removes all autosaves of this goal, when the results are complete.
  void remove();

 private:
  Status write_state(const World& world, UnfinishedRun& run);

  AutosaveFolder folder_;
  double interval_, next_;
  Timer since_;  // since the latest save
  const Scene& scene_;
  LoadedPatches loaded_;
  std::uint64_t loaded_hash_;
};

}  // namespace turgor
