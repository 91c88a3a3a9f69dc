// Recordings with one snapshot.
#pragma once

#include <filesystem>

#include <gtest/gtest.h>

#include "turgor/sim/pressed.hpp"
#include "turgor/sim/recording/recording.hpp"

namespace turgor::test {

/// Writes a recording with one snapshot of the present world, and returns the snapshot.
inline WorldSnapshot record_snapshot(const Exec& exec, const std::filesystem::path& file, const Scene& scene,
                                     const World& world) {
  WorldSnapshot snapshot;
  show(exec, world, snapshot);
  Result<RecordingWriter> writer = RecordingWriter::create(file, scene, world);
  EXPECT_TRUE(writer) << writer.error().message;
  if (!writer) return snapshot;
  EXPECT_TRUE(writer->add_snapshot(world, snapshot));
  EXPECT_TRUE(writer->finish(world, snapshot, make_pressed(world), "{}"));
  return snapshot;
}

/// Restores the first snapshot of a recording into a world that was loaded from the same scene.
inline WorldSnapshot restore_snapshot(const Exec& exec, const std::filesystem::path& file, World& world) {
  WorldSnapshot snapshot;
  const Result<Recording> recording = Recording::open(file);
  EXPECT_TRUE(recording) << recording.error().message;
  if (!recording) return snapshot;
  EXPECT_TRUE(recording->check_world(world));
  const Status restored = recording->restore(exec, 0, world, snapshot);
  EXPECT_TRUE(restored) << restored.error().message;
  return snapshot;
}

}  // namespace turgor::test
