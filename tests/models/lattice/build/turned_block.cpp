// A wound does not know how the lattice lies: in blocks that are turned in it, cuts gape as in one that lies
// along it.
#include "turgor/models/lattice/build/turned_block.hpp"

#include <cstdio>

#include <gtest/gtest.h>

#include "turgor/models/lattice/cutting/incision.hpp"

namespace turgor::lattice {
namespace {

struct Gapes {
  double across = 0, upright = 0;  // [m]
};
/// A T: a cut of 36 mm, 10 mm deep, and one of 30 mm that meets it from the side.
Gapes gapes_of_t(const Mat3d& turn, double step) {
  const Exec exec(2);
  Params params;
  params.tissue.law = TissueLaw::kSolid;
  params.skin.direction = turn.column[0];
  params.solver = {.sweeps = 20, .damping = 8};
  const Model model = turned_model({.step = step, .turn = turn}, params);
  State state = make_state(model);
  const auto cut = [&](Vec3d from, Vec3d to, int incision) {
    BladePath path = lay_blade(model, state, {.from = turn * from, .to = turn * to, .depth = 0.01}).value();
    cut_edges(model, state, path, 0, 1, incision);
    return path;
  };
  const double at = 0.37 * step;  // the blades go between nodes
  const BladePath across = cut({-0.018, at, 0}, {0.018, at, 0}, 0),
                  upright = cut({at, at - 0.03, 0}, {at, at + 0.0005, 0}, 1);
  for (int frame = 0; frame < 60; frame++) lattice::step(exec, model, state, {}, 1.0 / 30);
  return {measure_wound(model, state, across, 0).gape_max, measure_wound(model, state, upright, 1).gape_max};
}

TEST(lattice_turned, a_t_gapes_alike_however_the_body_lies_in_the_lattice) {
  const Gapes straight = gapes_of_t({}, 0.004);
  const std::vector<std::pair<double, Vec3d>> turns = {
      {5, {1, 0, 0}}, {15, {1, 0, 0}}, {15, {0, 1, 0}}, {33, {1, 0.8, 0.1}}, {40, {0.1, 1, 0.6}}};
  for (const auto& [degrees, axis] : turns) {
    const Gapes gapes = gapes_of_t(turn_about(axis, degrees), 0.004);
    std::printf("  %g° about (%g, %g, %g): %.2f and %.2f mm, straight %.2f and %.2f\n", degrees, axis.x,
                axis.y, axis.z, 1e3 * gapes.across, 1e3 * gapes.upright, 1e3 * straight.across,
                1e3 * straight.upright);
    EXPECT_NEAR(gapes.across, straight.across, 0.14 * straight.across);
    EXPECT_NEAR(gapes.upright, straight.upright, 0.08 * straight.upright);
  }
}

}  // namespace
}  // namespace turgor::lattice
