// A recording of the block with a cut.
#pragma once

#include <filesystem>

#include "tests/sim/block_scene.hpp"
#include "turgor/sim/pressed.hpp"
#include "turgor/sim/recording/recording.hpp"

namespace turgor::test {

/// Runs the block and records it in r.h5 with two snapshots; returns the world at the end.
inline World record_block(const std::filesystem::path& folder, const Scene& scene) {
  const Exec exec(1);
  World world = block_world(exec, scene);
  Result<RecordingWriter> writer = RecordingWriter::create(folder / "r.h5", scene, world);
  EXPECT_TRUE(writer) << writer.error().message;
  WorldSnapshot snapshot;
  show(exec, world, snapshot);
  EXPECT_TRUE(writer->add_snapshot(world, snapshot));
  for (int frame = 0; frame < 10; frame++) EXPECT_TRUE(step(exec, world));
  show(exec, world, snapshot);
  EXPECT_TRUE(writer->add_snapshot(world, snapshot));
  EXPECT_TRUE(writer->finish(world, snapshot, make_pressed(world), "{\"a\": 1}"));
  return world;
}

}  // namespace turgor::test
