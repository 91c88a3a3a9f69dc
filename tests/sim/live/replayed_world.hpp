// World of a haptic recording after its replay.
#pragma once

#include <gtest/gtest.h>

#include "turgor/sim/live/haptic_replay.hpp"
#include "turgor/sim/world.hpp"

namespace turgor::test {

inline World replayed_world(const HapticRecording& run, int threads) {
  const Exec exec(threads);
  const Result<Scene> scene = scene_of(run);
  EXPECT_TRUE(scene) << scene.error().message;
  Result<World> world = load_world(exec, *scene);
  EXPECT_TRUE(world) << world.error().message;
  auto replay = HapticReplay::begin(*world, run);
  EXPECT_TRUE(replay) << replay.error().message;
  for (int frame = 0; frame < run.frames; frame++) {
    EXPECT_TRUE((*replay)->next_frame(exec));
    EXPECT_TRUE(step(exec, *world));
  }
  (*replay)->end();
  return std::move(*world);
}

}  // namespace turgor::test
