// Runs of a pad under a fingertip, and its displayed surface.
#pragma once

#include <gtest/gtest.h>

#include "tests/sim/sfem_scene_text.hpp"

namespace turgor::test {

inline World run_world(const Exec& exec, const Scene& scene) {
  World world = sfem_world(exec, scene);
  for (int frame = 0; frame < frame_count(scene); frame++) EXPECT_TRUE(step(exec, world));
  return world;
}

/// The first body as it is displayed.
inline BodySnapshot shown_now(const Exec& exec, const World& world) {
  BodySnapshot snapshot;
  show(exec, world.sfem_bodies[0], snapshot);
  return snapshot;
}

}  // namespace turgor::test
