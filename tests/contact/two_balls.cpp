// Two balls pressed side by side into a lattice, against independent finite elements
// (tests/references/pressed_balls.py): linear elasticity on graded hexahedra of 27 nodes, balls as obstacles.
#include <array>
#include <cmath>
#include <cstdio>

#include <gtest/gtest.h>

#include "turgor/contact/lattice_touch.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::contact {
namespace {

constexpr double kVoxel = 1e-3, kRadius = 8e-3;  // [m]
constexpr double kPressYoung = 1e4, kRatio = 0.45;
constexpr Int3 kVoxels{96, 64, 26};
constexpr double kDeep = 1.2e-3, kFlat = 0.6e-3;  // depths of the tips [m]

/// A block of 96 x 64 mm, 25 mm above its fixed nodes, in cells of `cell` voxels, and two balls above it.
struct TwoBalls {
  lattice::Model model;
  lattice::State state;
  LatticeTouch touch;
  std::vector<Tool> tools{{Sphere{kRadius}, 0}, {Sphere{kRadius}, 0}};
  std::vector<ToolPose> at;
  std::vector<ToolForce> forces{2};
  std::array<Vec3d, 2> above;  // centers of balls that just touch

  TwoBalls(int cell, double apart, Vec3d shift) {
    CtVolume ct;
    ct.grid = {.size = kVoxels + Int3{0, 0, 6}, .spacing = {kVoxel, kVoxel, kVoxel}};
    for (int k = 0; k < ct.grid.size.z; k++)
      ct.samples.insert(ct.samples.end(), std::size_t(kVoxels.x * kVoxels.y),
                        k < kVoxels.z ? std::int16_t(0) : std::int16_t(-1000));
    lattice::Params params;
    params.block = {cell, cell, cell};
    params.fix_ends = true;
    params.skin.enabled = false;
    params.tissue.law = lattice::TissueLaw::kSolid;
    params.tissue.partial_cells = true;
    params.tissue.fat = params.tissue.muscle = kPressYoung;
    params.tissue.poisson = kRatio;
    params.solver = {.sweeps = 20, .damping = 8};
    model = lattice::build(Exec(2), ct, lattice::BodyFields{}, params).value();
    state = lattice::make_state(model);
    const lattice::BodySurface surface =
        lattice::build_surface(model, state.cuts, &ct, lattice::Extent::kAll, Exec(2));
    double top = 0;
    for (const Vec3 x : surface.rest) top = std::max(top, double(x.z));
    for (std::size_t t = 0; t < 2; t++) {
      above[t] = {0.5 * (kVoxels.x - 1) * kVoxel + (t == 0 ? -0.5 : 0.5) * apart,
                  0.5 * (kVoxels.y - 1) * kVoxel, model.anatomy.grid.origin.z + top + kRadius};
      above[t] += shift;
      at.push_back({{above[t], {}}, false});
    }
    touch = make_lattice_touch(model, state.cuts, surface, at);
  }
  /// Forces after a press to these depths of the tips, and a hold [N].
  std::array<double, 2> press(std::array<double, 2> depths) {
    constexpr int kPress = 12, kHold = 18;
    for (int n = 1; n <= kPress + kHold; n++) {
      const double share = std::min(1.0, double(n) / kPress);
      for (std::size_t t = 0; t < 2; t++) at[t].pose.position = above[t] - Vec3d{0, 0, depths[t] * share};
      EXPECT_TRUE(step_with_tools(Exec(2), model, state, touch, tools, at, {}, 1.0 / 60, forces).finite);
    }
    return {forces[0].force.z, forces[1].force.z};
  }
};

/// Forces of the independent program, 17 mm between the centers: of a ball alone, and of both [N].
struct Independent {
  double flat, deep, both_deep, flat_beside_deep, deep_beside_flat;
};
// bricks of 1.2 mm below the balls
constexpr Independent kIndependent{.flat = 0.02408,
                                   .deep = 0.06873,
                                   .both_deep = 0.06721,
                                   .flat_beside_deep = 0.02309,
                                   .deep_beside_flat = 0.06821};
// Changes with bricks of 1.6 mm: forces by up to 2.9 %, their ratios by up to 0.0028.
constexpr double kForceError = 0.03, kRatioError = 0.003;

/// Expected error e of a force on a lattice in cells of `h`, as reports give it: e = 0.05 + 0.4 (h/a)^2.5
/// with the radius of contact a = √(R d).
double lattice_error(double h, double depth) {
  return 0.05 + 0.4 * std::pow(h / std::sqrt(kRadius * depth), 2.5);
}
/// Expected error of 1 − r, with the ratio r of a force beside a neighbor to that alone. The neighbor takes a
/// little of the depth, so that 1 − r is proportional to the exponent of F ∝ (1 + e) d^1.5, which is 1.5
/// − 1.25 e/(1 + e).
double ratio_error(double h, double depth) {
  const double e = lattice_error(h, depth);
  return 1.25 / 1.5 * e / (1 + e);
}

// Two balls side by side weaken each other as much as in the independent program, on nodes and beside them.
TEST(TwoBalls, NeighborWeakensForceAsInElements) {
  const Independent& known = kIndependent;
  for (const double shift : {0.0, 0.001}) {
    TwoBalls balls(2, 0.017, {shift, shift, 0});
    constexpr double kAway = -0.01;
    const double deep = balls.press({kDeep, kAway})[0];
    const std::array<double, 2> both = balls.press({kDeep, kDeep}), mixed = balls.press({kFlat, kDeep});
    const double flat = balls.press({kFlat, kAway})[0];
    std::printf("alone %.5f, %.5f N (independent %.5f, %.5f); ratios %.4f, %.4f, %.4f (%.4f, %.4f, %.4f)\n",
                deep, flat, known.deep, known.flat, both[0] / deep, mixed[0] / flat, mixed[1] / deep,
                known.both_deep / known.deep, known.flat_beside_deep / known.flat,
                known.deep_beside_flat / known.deep);
    // forces
    constexpr double kCell = 2 * kVoxel;
    EXPECT_NEAR(deep, known.deep, (lattice_error(kCell, kDeep) + kForceError) * known.deep);
    EXPECT_NEAR(flat, known.flat, (lattice_error(kCell, kFlat) + kForceError) * known.flat);
    EXPECT_NEAR(both[0], both[1], 1e-3 * deep) << "the block is symmetric";
    // ratios
    const auto expect_ratio = [&](double found, double expected, double depth) {
      EXPECT_NEAR(found, expected, kRatioError + ratio_error(kCell, depth) * (1 - expected));
    };
    expect_ratio(both[0] / deep, known.both_deep / known.deep, kDeep);
    expect_ratio(mixed[0] / flat, known.flat_beside_deep / known.flat, kFlat);
    expect_ratio(mixed[1] / deep, known.deep_beside_flat / known.deep, kDeep);
  }
}

}  // namespace
}  // namespace turgor::contact
