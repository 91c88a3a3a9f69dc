// recording.h5: the scene, which CT it ran on, and the state of every body at each snapshot. Enough to draw
// all pictures again without simulating, and plain enough to be read from Python or MATLAB (the layout is
// described in docs/recording.md).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/io/files/hdf5_file.hpp"
#include "turgor/sim/pressed.hpp"
#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/snapshot.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// Written while the simulation runs.
class RecordingWriter {
 public:
  static Result<RecordingWriter> create(const std::filesystem::path& path, const Scene& scene,
                                        const World& world);
  /// `shown`: the world as it looks now.
  Status add_snapshot(const World& world, const WorldSnapshot& snapshot);
  /// What every tool felt, bodies when they were pressed most, and the run's report, as JSON; last.
  Status finish(const World& world, const WorldSnapshot& snapshot, const std::vector<Pressed>& pressed,
                const std::string& report);

 private:
  explicit RecordingWriter(Hdf5File file) : file_(std::move(file)) {}

  Hdf5File file_;
  int snapshots_ = 0;
};

/// Read to be drawn again.
class Recording {
 public:
  /// Error: no recording, from another version, damaged, or never finished.
  static Result<Recording> open(const std::filesystem::path& path);

  /// The scene as it ran; more overrides may say where the CT is now, and what to draw.
  Result<Scene> scene(const std::vector<std::string>& more_overrides) const;
  /// Error: the world is made of other CTs, or of other parameters, than the recording.
  Status check_world(const World& world) const;
  int snapshot_count() const { return snapshots_; }
  /// Puts the world into the state of a snapshot, and shows it as it was recorded.
  Status restore(const Exec& exec, int index, World& world, WorldSnapshot& snapshot) const;
  /// What every tool felt in the whole run, and bodies when they were pressed most.
  Status restore_touch(World& world, std::vector<Pressed>& pressed) const;
  const std::string& report() const { return report_; }
  const std::filesystem::path& path() const { return path_; }

 private:
  explicit Recording(Hdf5File file, std::filesystem::path path)
      : file_(std::move(file)), path_(std::move(path)) {}
  Status restore_cut(const std::string& group, Cut& cut) const;

  Hdf5File file_;
  std::filesystem::path path_;
  int snapshots_ = 0;
  std::string report_;
};

}  // namespace turgor
