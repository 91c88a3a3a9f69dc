// Solid cells up to a Poisson's ratio of 0.499: bars, beams and presses have the stiffness of the closed
// forms and come to rest, with few sweeps and at several frame rates.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/solver/step_sequence.hpp"

namespace turgor::lattice {
namespace {

const Exec kOne(1);
constexpr double kModulus = 2e4;  // [Pa]

Params dense_params(double poisson, int sweeps, double damping) {
  Params params;
  params.skin.enabled = false;
  params.tissue.law = TissueLaw::kSolid;
  params.tissue.poisson = poisson;
  params.solver.sweeps = sweeps, params.solver.damping = damping;
  return params;
}

/// Share of node i of a loaded row of `cells` cells.
double node_share(int i, int cells) { return (i == 0 || i == cells ? 0.5 : 1.0) / cells; }

/// A bar of cells along x, held at its left end, with a dead force on its right end.
struct Bar {
  Int3 cells;
  double spacing;
  Model model;
  State state;
  std::vector<NodeLoad> loads;

  Bar(Int3 of, double h, const Params& params, Vec3d force)
      : cells(of),
        spacing(h),
        model(block_model({.size = of + Int3{1, 1, 1},
                           .spacing = h,
                           .young = kModulus,
                           .skin_on_top = false,
                           .is_fixed = [](Int3 p) { return p.x == 0; }},
                          params)),
        state(make_state(model)) {
    for (int k = 0; k <= cells.z; k++)
      for (int j = 0; j <= cells.y; j++)
        loads.push_back({node_slot(model.anatomy.lattice, {cells.x, j, k}),
                         Vec3(force * (node_share(j, cells.y) * node_share(k, cells.z)))});
    std::sort(loads.begin(), loads.end(), [](const auto& a, const auto& b) { return a.slot < b.slot; });
  }
  void run(double seconds, double rate) {
    for (int n = 0; n < std::lround(seconds * rate); n++)
      step(kOne, model, state, {.loads = loads}, 1 / rate);
  }
  Vec3d at(Int3 p) const { return Vec3d(state.motion.u[std::size_t(node_slot(model.anatomy.lattice, p))]); }
  double width() const { return cells.y * spacing; }
};

struct BarCase {
  double poisson;
  int sweeps;
  double rate;
};

// A pressed bar with free sides has the modulus within 1 % and widens by Poisson's ratio within 0.003, at
// rest and still after seconds, with even and odd numbers of sweeps.
TEST(NearlyIncompressible, FreeBarFollowsHooke) {
  constexpr double kStrain = -0.005;
  for (const auto [poisson, sweeps, rate] :
       {BarCase{0.49, 5, 240}, BarCase{0.495, 6, 60}, BarCase{0.499, 4, 60}, BarCase{0.499, 7, 240},
        BarCase{0.499, 10, 120}}) {
    const double force = kStrain * kModulus * 0.008 * 0.008;
    Bar bar({20, 4, 4}, 0.002, dense_params(poisson, sweeps, 4), {force, 0, 0});
    for (int seconds = 1; seconds <= 4; seconds++) {
      bar.run(1, rate);
      const double along = (bar.at({16, 2, 2}).x - bar.at({8, 2, 2}).x) / (8 * bar.spacing);
      const double across = (bar.at({12, 4, 2}).y - bar.at({12, 0, 2}).y) / bar.width();
      EXPECT_NEAR(along / kStrain, 1, 0.01) << poisson << ", " << sweeps << " sweeps, " << rate << "/s";
      EXPECT_NEAR(-across / along, poisson, 0.003)
          << poisson << ", " << sweeps << " sweeps, " << rate << "/s";
    }
  }
}

// A cantilever bends as Timoshenko's beam within 2 %: it does not lock.
TEST(NearlyIncompressible, CantileverDoesNotLock) {
  for (const double poisson : {0.49, 0.495, 0.499}) {
    constexpr Int3 kCells{40, 5, 5};
    constexpr double kSpacing = 0.002;
    const double side = kCells.y * kSpacing, length = kCells.x * kSpacing;
    const double inertia = std::pow(side, 4) / 12, shear = kModulus / (2 * (1 + poisson));
    const double force = 0.01 * 3 * kModulus * inertia / (length * length);
    const double shape = 10 * (1 + poisson) / (12 + 11 * poisson);  // [Cowper 1966]
    const double expected = force * std::pow(length, 3) / (3 * kModulus * inertia) +
                            force * length / (shape * shear * side * side);
    Bar beam(kCells, kSpacing, dense_params(poisson, 10, 6), {0, 0, -force});
    beam.run(4, 60);
    EXPECT_NEAR(-beam.at({kCells.x, 2, 2}).z / expected, 1, 0.02) << poisson;
  }
}

/// Settled displacement of the middle of a pressed square on a block, over that of a half space, p a 1.1222
/// (1 − ν²)/E [Johnson 1985].
double pressed_square(double poisson, int sweeps) {
  constexpr int kWide = 16, kHigh = 12, kSide = 4;
  constexpr double kSpacing = 0.004;
  const Model model = block_model({.size = {kWide + 1, kWide + 1, kHigh + 1},
                                   .spacing = kSpacing,
                                   .young = kModulus,
                                   .skin_on_top = false,
                                   .is_fixed = [](Int3 p) { return p.z == 0; }},
                                  dense_params(poisson, sweeps, 8));
  const double pressure = 0.004 * kModulus, side = kSide * kSpacing;
  const int low = (kWide - kSide) / 2;
  std::vector<NodeLoad> loads;
  for (int j = 0; j <= kSide; j++)
    for (int i = 0; i <= kSide; i++)
      loads.push_back({node_slot(model.anatomy.lattice, {low + i, low + j, kHigh}),
                       {0, 0, Real(-pressure * side * side * node_share(i, kSide) * node_share(j, kSide))}});
  std::sort(loads.begin(), loads.end(), [](const auto& a, const auto& b) { return a.slot < b.slot; });
  State state = make_state(model);
  for (int n = 0; n < 75; n++) step(kOne, model, state, {.loads = loads}, 1.0 / 60);
  const auto middle = std::size_t(node_slot(model.anatomy.lattice, {kWide / 2, kWide / 2, kHigh}));
  return -double(state.motion.u[middle].z) / (pressure * side * 1.1222 * (1 - poisson * poisson) / kModulus);
}

// A pressed square sinks as on a half space, except for the block's size, which matters alike at all ratios.
TEST(NearlyIncompressible, PressedSquareFollowsHalfSpace) {
  const double before = pressed_square(0.45, 6);
  EXPECT_NEAR(before, 0.9, 0.06) << "the base is three sides deep";
  for (const double poisson : {0.495, 0.499})
    EXPECT_NEAR(pressed_square(poisson, 10) / before, 1, 0.015) << poisson;
}

/// Settled deflection of Cook's panel at the middle of its right end, over that of sfem's elements [m/m]: 48
/// mm long, 44 mm high at the left and 16 mm at the right, clamped at the left. Its oblique sides are steps.
double cook_panel(double poisson) {
  constexpr Int3 kCells{24, 30, 2};
  constexpr double kSpacing = 0.002, kForce = 0.004;
  Block block{.size = kCells + Int3{1, 1, 1},
              .spacing = kSpacing,
              .young = kModulus,
              .skin_on_top = false,
              .is_fixed = [](Int3 p) { return p.x == 0; }};
  BodyNodes nodes = block_nodes(block);
  for (int k = 0; k <= kCells.z; k++)
    for (int j = 0; j <= kCells.y; j++)
      for (int i = 0; i <= kCells.x; i++) {
        const double along = double(i) / kCells.x, low = 22 * along, high = 22 + 8 * along;  // in cells
        if (j >= low - 0.5 && j <= high + 0.5) continue;
        const std::size_t n = sample_index(nodes.grid, i, j, k);
        nodes.tissue[n] = Tissue::kOutside, nodes.hu[n] = kAirHu, nodes.young[n] = 0, nodes.fixed[n] = 0;
      }
  const Model model = assemble(kOne, nodes, nullptr, dense_params(poisson, 10, 6)).value();
  std::vector<NodeLoad> loads;
  constexpr int kLow = 22, kEnd = 8;
  for (int k = 0; k <= kCells.z; k++)
    for (int j = 0; j <= kEnd; j++)
      loads.push_back({node_slot(model.anatomy.lattice, {kCells.x, kLow + j, k}),
                       {0, Real(kForce * node_share(j, kEnd) * node_share(k, kCells.z)), 0}});
  std::sort(loads.begin(), loads.end(), [](const auto& a, const auto& b) { return a.slot < b.slot; });
  State state = make_state(model);
  for (int n = 0; n < 120; n++) step(kOne, model, state, {.loads = loads}, 1.0 / 60);
  const auto end = std::size_t(node_slot(model.anatomy.lattice, {kCells.x, kLow + kEnd / 2, 1}));
  // 23.86 mm for 1 N, 100 kPa and a thickness of 10 mm, at every ratio
  const double expected = 0.02386 * kForce * (1e5 / kModulus) * (0.01 / (kCells.z * kSpacing));
  return double(state.motion.u[end].y) / expected;
}

// Cook's panel is as compliant at 0.499 as at 0.3.
TEST(NearlyIncompressible, CooksPanelDoesNotLock) {
  const double before = cook_panel(0.3);
  EXPECT_NEAR(before, 1, 0.1) << "its oblique sides are steps";
  EXPECT_NEAR(cook_panel(0.499) / before, 1, 0.03);
}

// A bar that is pulled by a fifth of its length, and one that bends far, keep their volume within 1 %, in
// every cell that is not beside the clamp or the load.
TEST(NearlyIncompressible, FarDeformedBarsKeepTheirVolume) {
  const auto largest = [](const Bar& bar) {
    double most = 0;
    for (int i = 1; i + 1 < bar.cells.x; i++)
      for (int j = 0; j < bar.cells.y; j++)
        for (int k = 0; k < bar.cells.z; k++) {
          // columns of F at the center of the cell
          Vec3d f[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
          for (int c = 0; c < 8; c++) {
            const Int3 corner{c & 1, c >> 1 & 1, c >> 2};
            const Vec3d u = bar.at(Int3{i, j, k} + corner);
            for (int axis = 0; axis < 3; axis++) f[axis] += u * ((corner[axis] ? 1 : -1) / (4 * bar.spacing));
          }
          most = std::max(most, std::abs(dot(f[0], cross(f[1], f[2])) - 1));
        }
    return most;
  };
  Bar pulled({10, 4, 4}, 0.002, dense_params(0.499, 10, 6), {0.2 * kModulus * 0.008 * 0.008, 0, 0});
  pulled.run(2, 60);
  EXPECT_GT(pulled.at({10, 2, 2}).x, 0.2 * 0.02);
  EXPECT_LT(largest(pulled), 0.01);
  Bar bent({20, 4, 4}, 0.002, dense_params(0.499, 10, 6), {0, 0, -0.01 * kModulus * 0.008 * 0.008});
  bent.run(2, 60);
  EXPECT_LT(bent.at({20, 2, 2}).z, -0.3 * 0.04);
  EXPECT_LT(largest(bent), 0.01);
}

// Few odd sweeps get one more where tissue is nearly incompressible, and in layers that slide; others do not.
TEST(NearlyIncompressible, OddSweepsAreRoundedUp) {
  Params params = dense_params(0.45, 5, 1);
  EXPECT_EQ(vbd_sweeps(params), 5);
  params.tissue.layers = {{.name = "fascia", .young = 1e3, .poisson = 0.45, .slide = 0.05}};
  EXPECT_EQ(vbd_sweeps(params), 6);
  EXPECT_EQ(vbd_sweeps(dense_params(0.49, 7, 1)), 8);
  EXPECT_EQ(vbd_sweeps(dense_params(0.49, 8, 1)), 8);
  EXPECT_EQ(vbd_sweeps(dense_params(0.45, 3, 1)), 4);
  params = dense_params(0.45, 5, 1);
  params.tissue.law = TissueLaw::kSprings, params.tissue.poisson = 0.49;
  EXPECT_EQ(vbd_sweeps(params), 5);
}

}  // namespace
}  // namespace turgor::lattice
