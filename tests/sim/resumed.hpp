// A world that goes on from the state file of another one.
#pragma once

#include <filesystem>

#include <gtest/gtest.h>

#include "turgor/sim/autosave/world_file.hpp"

namespace turgor::test {

/// Writes a world to a state file and reads it into `resumed`, which was loaded from the same scene;
/// `loaded`: patches when both were loaded. Steps both; they must keep the same bits.
inline void expect_resumes(const Exec& exec, const std::filesystem::path& path, const LoadedPatches& loaded,
                           World& world, World& resumed) {
  {
    Result<StateWriter> file = StateWriter::create(path);
    ASSERT_TRUE(file);
    write_world(*file, world, loaded);
    ASSERT_TRUE(file->close());
  }
  Result<StateReader> file = StateReader::open(path);
  ASSERT_TRUE(file);
  read_world(exec, *file, loaded_patches(resumed), resumed);
  ASSERT_TRUE(file->is_sound());
  for (int frame = 0; frame < 5; frame++) ASSERT_TRUE(step(exec, world) && step(exec, resumed));
  EXPECT_EQ(state_hash(world), state_hash(resumed));
}

}  // namespace turgor::test
