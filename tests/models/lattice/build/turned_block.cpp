// Wounds are independent of the lattice's orientation: cuts gape alike in rotated blocks and in an aligned
// one.
#include "turgor/models/lattice/build/turned_block.hpp"

#include <cstdio>

#include <gtest/gtest.h>

#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {
namespace {

struct Gapes {
  double across = 0, upright = 0;  // [m]
};
/// A T: a cut of 36 mm, 10 mm deep, and one of 30 mm that meets it from the side.
Gapes gapes_of_t(const Mat3d& rotation, double step) {
  const Exec exec(2);
  Params params;
  params.tissue.law = TissueLaw::kSolid;
  params.skin.direction = rotation.column[0];
  params.solver = {.sweeps = 20, .damping = 8};
  const Model model = rotated_model({.spacing = step, .rotation = rotation}, params);
  State state = make_state(model);
  const auto cut = [&](Vec3d from, Vec3d to, int incision) {
    BladePath path =
        lay_blade(model, state, {.from = rotation * from, .to = rotation * to, .depth = 0.01}).value();
    cut_edges(model, state, path, 0, 1, incision);
    return path;
  };
  const double at = 0.37 * step;  // the blades pass between nodes
  const BladePath across = cut({-0.018, at, 0}, {0.018, at, 0}, 0),
                  upright = cut({at, at - 0.03, 0}, {at, at + 0.0005, 0}, 1);
  for (int frame = 0; frame < 60; frame++) lattice::step(exec, model, state, {}, 1.0 / 30);
  return {measure_wound(model, state, across, 0).gape_max, measure_wound(model, state, upright, 1).gape_max};
}

// A T-shaped wound gapes alike in any rotation of the body against the lattice.
TEST(RotatedBlock, GapeIndependentOfRotation) {
  const Gapes straight = gapes_of_t({}, 0.004);
  const std::vector<std::pair<double, Vec3d>> rotations = {
      {5, {1, 0, 0}}, {15, {1, 0, 0}}, {15, {0, 1, 0}}, {33, {1, 0.8, 0.1}}, {40, {0.1, 1, 0.6}}};
  for (const auto& [degrees, axis] : rotations) {
    const Gapes gapes = gapes_of_t(rotation_about(axis, degrees), 0.004);
    std::printf("  %g° about (%g, %g, %g): %.2f and %.2f mm, straight %.2f and %.2f\n", degrees, axis.x,
                axis.y, axis.z, 1e3 * gapes.across, 1e3 * gapes.upright, 1e3 * straight.across,
                1e3 * straight.upright);
    EXPECT_NEAR(gapes.across, straight.across, 0.14 * straight.across);
    EXPECT_NEAR(gapes.upright, straight.upright, 0.08 * straight.upright);
  }
}

}  // namespace
}  // namespace turgor::lattice
