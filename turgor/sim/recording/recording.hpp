// recording.h5: the scene, the identity of its CT, and the state of every body at each snapshot. A recording
// is sufficient to draw all pictures without simulation. Python and MATLAB can read it; docs/recording.md
// describes the layout.
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

/// Writer of a recording during a simulation.
class RecordingWriter {
 public:
  static Result<RecordingWriter> create(const std::filesystem::path& path, const Scene& scene,
                                        const World& world);
  /// Continues a recording of `snapshots` snapshots that was not finished.
  static Result<RecordingWriter> resume(const std::filesystem::path& path, int snapshots);
  /// Appends a snapshot of the present world.
  Status add_snapshot(const World& world, const WorldSnapshot& snapshot);
  int snapshot_count() const { return snapshots_; }
  /// Writes the logs of all tools, the bodies under their largest forces, and the run's report as JSON; call
  /// last.
  Status finish(const World& world, const WorldSnapshot& snapshot, const std::vector<Pressed>& pressed,
                const std::string& report);

 private:
  explicit RecordingWriter(Hdf5File file, int snapshots = 0)
      : file_(std::move(file)), snapshots_(snapshots) {}

  Hdf5File file_;
  int snapshots_;
};

/// Reader of a recording.
class Recording {
 public:
  /// Error: not a recording, another format, damaged, or unfinished.
  static Result<Recording> open(const std::filesystem::path& path);

  /// Scene of the run; further overrides may change output keys and the location of the CT.
  Result<Scene> scene(const std::vector<std::string>& more_overrides) const;
  /// Error: the world has other CTs, cloth meshes or parameters than the recording.
  Status check_world(const World& world) const;
  int snapshot_count() const { return snapshots_; }
  /// Restores the state of a snapshot, and the recorded surfaces.
  Status restore(const Exec& exec, int index, World& world, WorldSnapshot& snapshot) const;
  /// Logs of all tools of the whole run, and bodies under their largest forces.
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
