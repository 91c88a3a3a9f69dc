// Ticks along random paths: forces and positions stay finite for any motion of a hand.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/contact/touched_half_space.hpp"

namespace turgor::contact {
namespace {

/// Ticks with smooth drags, jumps, rotations, non-finite poses and grasps. Returns the largest force.
double fuzz(std::vector<Tool> tools, int ticks) {
  const std::size_t count = tools.size();
  Touched scene({.side = 9}, std::move(tools), {.viscosity = one_pair(2, 0.05)});
  std::mt19937 random(11);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto random_vector = [&] { return Vec3d{number(random), number(random), number(random)}; };
  const Vec3d home{0, 0, 3e-3};
  std::vector<Vec3d> at(count, home), velocity(count);
  std::vector<ToolPose> poses(count);
  double angle = 0, largest = 0, unsolved = 0;
  for (int tick = 0; tick < ticks; tick++) {
    for (std::size_t i = 0; i < count; i++) {
      velocity[i] = 0.98 * velocity[i] + random_vector() * 2e-5 - (at[i] - home) * 1e-3;
      at[i] += velocity[i];
      if (random() % 2000 == 0) at[i] = random_vector() * 8e-3;
      angle += 0.02 * number(random);
      const double c = std::cos(angle), s = std::sin(angle);
      poses[i] = {{at[i], {{{c, 0, s}, {0, 1, 0}, {-s, 0, c}}}}, (std::size_t(tick) / 97 + i) % 5 == 0};
    }
    if (random() % 1000 == 0) poses[0].pose.position.x = NAN;
    solve_touch_tick(scene.patch, scene.state, scene.tools, poses, tick % 100 == 0 ? 0 : kTick, scene.forces);
    unsolved += scene.state.solution.residual > 1e-3;
    for (const ToolForce& haptic : scene.forces) {
      const double size = norm(haptic.force) + norm(haptic.torque);
      if (!(size <= largest)) largest = size;
    }
    if (!std::isfinite(largest)) break;
  }
  for (const Vec3d x : scene.state.x) EXPECT_TRUE(std::isfinite(norm(x)));
  std::printf("largest force %.3f N; %.2f %% of ticks with a residual above 1e-3\n", largest,
              100.0 * unsolved / ticks);
  EXPECT_LT(unsolved, 0.05 * ticks);
  return largest;
}

// The force along a random path of one tool stays below 10 N.
TEST(TouchRandom, OneTool_ForceIsBounded) { EXPECT_LT(fuzz({{Sphere{3e-3}, 0.3}}, 70'000), 10); }

// The forces along random paths of two tools, which may overlap, stay finite.
TEST(TouchRandom, TwoTools_ForceIsFinite) {
  EXPECT_LT(fuzz({{Sphere{3e-3}, 0.3}, {Capsule{1e-3, 4e-3}, 0.8}}, 30'000), 1e9);
}

}  // namespace
}  // namespace turgor::contact
