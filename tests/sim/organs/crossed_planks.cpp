// Bodies that touch with their edges only: planks across each other.
#include <cmath>

#include <fmt/format.h>

#include "organs_scene.hpp"

namespace turgor {
namespace {

using test::advance;
using test::organs_world;

/// A plank across a fixed one, half a millimeter above it, under gravity that is tilted by an angle [rad].
World plank_world(const Exec& exec, double angle, double friction) {
  return organs_world(
      exec,
      fmt::format(
          "[world]\nduration = 20\ngravity = [{}, 0, {}]\n"
          "[body.low]\nmodel = \"rigid\"\nshape = {{ box = [0.6, 0.04, 0.02] }}\nfixed = true\nmass = 1\n"
          "[body.high]\nmodel = \"rigid\"\nshape = {{ box = [0.04, 0.2, 0.02] }}\n"
          "at = [-0.2, 0.003, 0.0205]\nmass = 0.2\n"
          "[contact.cross]\nbetween = [\"high\", \"low\"]\nfriction = {}\n",
          9.81 * std::sin(angle), -9.81 * std::cos(angle), friction));
}

const RigidBody& high_plank(const World& world) {
  return world.rigid_bodies[world.rigid_bodies[0].name == "high" ? 0 : 1];
}

// No vertex of either plank is inside the other one: the crossings of their edges bear the weight.
TEST(CrossedPlanks, HighPlank_RestsOnLowOne) {
  const Exec exec(2);
  World world = plank_world(exec, 0, 0.3);
  advance(exec, world, 120);
  const RigidBody& plank = high_plank(world);
  const Vec3d force = world.coupling.contacts[0].samples.back().force;
  const double weight = 0.2 * 9.81;
  EXPECT_LT(norm(force - Vec3d{0, 0, weight}), 1e-3 * weight);
  EXPECT_LT(norm(plank.state.center - Vec3d{-0.2, 0.003, 0.02}), 2e-4);
  EXPECT_LT(norm(plank.state.velocity), 1e-6);
  EXPECT_EQ(world.coupling.unsolved, 0);
}

// On a slope the plank rests below the friction angle, and slides above it with g (sin θ − μ cos θ).
TEST(CrossedPlanks, Slope_SlidesAboveFrictionAngle) {
  const Exec exec(2);
  constexpr double kFriction = 0.4;
  for (const double factor : {0.8, 1.5}) {
    const double angle = std::atan(factor * kFriction);
    World world = plank_world(exec, angle, kFriction);
    advance(exec, world, 12);
    const double before = high_plank(world).state.velocity.x;
    advance(exec, world, 24);
    const double acceleration = (high_plank(world).state.velocity.x - before) / (24 * world.dt);
    const double expected = std::max(0.0, 9.81 * (std::sin(angle) - kFriction * std::cos(angle)));
    std::printf("tan = %.1f mu: %.4f m/s² of %.4f, %.3g m/s\n", factor, acceleration, expected, before);
    EXPECT_NEAR(acceleration, expected, 0.02 * 9.81 * std::sin(angle));
  }
}

// Planks of finite elements, none of whose vertices is inside the other one: the crossings of their edges
// bear the weight.
TEST(CrossedPlanks, TissuePlank_RestsOnOther) {
  const Exec exec(2);
  World world = organs_world(
      exec,
      "[world]\nduration = 20\ngravity = [0, 0, -9.81]\n" +
          test::block_text("low", "[-0.3, -0.02, -0.01]", "[0.6, 0.04, 0.02]", "[5, 1, 1]", "bottom", 1e6) +
          test::block_text("high", "[-0.26, -0.097, 0.0105]", "[0.04, 0.2, 0.02]", "[1, 3, 1]", "none", 1e6) +
          "density = 1000\n[contact.cross]\nbetween = [\"high\", \"low\"]\nfriction = 0.3\n");
  advance(exec, world, 120);
  const double weight = 0.16 * 9.81;
  const CouplingSample& sample = world.coupling.contacts[0].samples.back();
  std::printf("%.5f N of %.5f N on %d sites\n", sample.force.z, weight, sample.bearing);
  EXPECT_LT(norm(sample.force - Vec3d{0, 0, weight}), 1e-3 * weight);
  EXPECT_EQ(world.coupling.unsolved, 0);
}

}  // namespace
}  // namespace turgor
