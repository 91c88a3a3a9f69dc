#include "turgor/sim/report/trembling.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "turgor/sim/report/report_touch.hpp"

namespace turgor {
namespace {

/// A world with a tool on a lattice, which lies still from 0.1 s on with forces around 1 N.
World resting_world(const std::vector<double>& forces, BodyKind kind = BodyKind::kLattice) {
  World world;
  LatticeBody body;
  body.name = "pad";
  body.model.params.solver.sweeps = 5;
  world.lattice_bodies.push_back(std::move(body));
  TouchingTool tool;
  tool.name = "finger";
  tool.body = {kind, 0};
  for (int n = 0; n < 6; n++)
    tool.samples.append(
        {.time = n / 60.0, .position = {0, 1e-3 * n, 0}, .force = {0, 0.1 * n, 0}, .contacts = 3});
  for (std::size_t n = 0; n < forces.size(); n++)
    tool.samples.append(
        {.time = 0.1 + double(n) / 60, .position = {0, 6e-3, 0}, .force = {0, forces[n], 0}, .contacts = 3});
  world.tools.push_back(std::move(tool));
  return world;
}

std::vector<double> wave(double amplitude, int period) {
  std::vector<double> forces;
  for (int n = 0; n < 60; n++) forces.push_back(1 + amplitude * std::cos(2 * std::numbers::pi * n / period));
  return forces;
}

// A force that goes up and down every second frame trembles by its amplitude, in a note with the sweeps.
TEST(Trembling, AlternatingForceIsReported) {
  const World world = resting_world(wave(0.2, 2));
  const std::optional<Trembling> found = force_trembling(world.tools[0]);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->swing, 0.2, 1e-9);
  EXPECT_NEAR(found->mean, 1, 1e-9);
  EXPECT_GT(found->from, 0.1);
  const std::vector<std::string> warnings = touch_warnings(world);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(warnings[0].starts_with("finger: its force trembles by 20 % around 1 N")) << warnings[0];
  EXPECT_TRUE(warnings[0].ends_with("5 sweeps a frame do not converge; more body.pad.solver.sweeps"))
      << warnings[0];
}

// Small changes, vibrations of tissue over many frames, relaxation and other models do not tremble.
TEST(Trembling, OtherForcesAreNot) {
  EXPECT_FALSE(force_trembling(resting_world(wave(0.04, 2)).tools[0]));
  EXPECT_FALSE(force_trembling(resting_world(wave(0.2, 12)).tools[0]));
  EXPECT_FALSE(force_trembling(resting_world(wave(0.2, 2), BodyKind::kSfem).tools[0]));
  std::vector<double> relaxing;
  for (int n = 0; n < 60; n++) relaxing.push_back(1 + std::exp(-0.1 * n));
  EXPECT_FALSE(force_trembling(resting_world(relaxing).tools[0]));
}

// A tool that moves feels other nodes from frame to frame, which is no trembling.
TEST(Trembling, MovingToolIsNot) {
  World world = resting_world({});
  for (int n = 0; n < 60; n++)
    world.tools[0].samples.append({.time = 0.1 + n / 60.0,
                                   .position = {1e-4 * n, 6e-3, 0},
                                   .force = {0, n % 2 ? 1.2 : 0.8, 0},
                                   .contacts = 3});
  EXPECT_FALSE(force_trembling(world.tools[0]));
}

}  // namespace
}  // namespace turgor
