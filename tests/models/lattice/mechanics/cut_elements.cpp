// Cells and skin that a blade divided keep their stiffness on each side.
#include "turgor/models/lattice/mechanics/cut_elements.hpp"

#include <cmath>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include "tests/models/lattice/wounded_block.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/model/colors.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {
namespace {

const Exec kOne(1);

/// Energy of a bar of 13 × 5 × 5 nodes whose ends are held δ apart, relative to ½ E A δ²/L. An upright blade
/// cuts it from end to end, `aside` cells from its side and at an angle; `aside` = 0 means no cut.
double stored(double aside, double degrees) {
  constexpr double kStep = 0.004, kStretch = 0.001, kLength = 12 * kStep, kYoung = 1e4;
  const Block block{
      .size = {13, 5, 5}, .young = kYoung, .is_fixed = [](Int3 p) { return p.x == 0 || p.x == 12; }};
  Params params = solid_params(20, 8, 1e-4);
  params.tissue.poisson = 0;
  params.skin.stiffness = params.skin.shear = 1e-3;
  const Model model = block_model(block, params);
  State state = make_state(model);
  if (aside > 0) {
    const double slope = std::tan(degrees * std::numbers::pi / 180), y = aside * kStep;
    const Incision blade{
        .from = {0, y, 4 * kStep}, .to = {kLength, y + slope * kLength, 4 * kStep}, .depth = 0.03};
    EXPECT_GT(cut_edges(model, state, lay_blade(model, state, blade).value(), 0, 1, 0), 40);
    EXPECT_GT(state.cut_elements.virtual_nodes.size(), 50u);
  }
  for (int j = 0; j < 5; j++)
    for (int k = 0; k < 5; k++)
      state.motion.u.set(std::size_t(node_slot(model.anatomy.lattice, 12, j, k)), {Real(kStretch), 0, 0});
  for (int n = 0; n < 100; n++) EXPECT_TRUE(step(kOne, model, state, {}, 1.0 / 60).finite);
  return energy(kOne, model, state) / (0.5 * kYoung * 16 * kStep * kStep * kStretch * kStretch / kLength);
}

/// Two bars side by side with widths from a to b and from 4 − a to 4 − b. The stiffness of each follows from
/// its mean compliance.
double of_tapered_bars(double a, double b) {
  const auto stiffness = [](double from, double to) {
    return std::abs(to - from) > 1e-6 ? (to - from) / std::log(to / from) : from;
  };
  return (stiffness(a, b) + stiffness(4 - a, 4 - b)) / 4;
}

// A bar that is split along its length has the stiffness of its two halves.
TEST(CutElements, SplitBarKeepsStiffness) {
  EXPECT_NEAR(stored(0, 0), 1, 0.01) << "of E A/L";
  for (const double aside : {1.5, 1.7, 2.05, 3.9})
    EXPECT_NEAR(stored(aside, 0), 1, 0.01) << "cut " << aside << " cells aside";
  const double end = 0.6 + 12 * std::tan(10 * std::numbers::pi / 180);
  EXPECT_NEAR(stored(0.6, 10), of_tapered_bars(0.6, end), 0.05) << "oblique cut";
}

// A wound gapes alike for any position and direction of its blade in the cells.
TEST(CutElements, GapeIndependentOfBladeInCell) {
  Params params = solid_params(10, 4, 45);
  params.tissue.poisson = 0.45;
  double least = 1, most = 0;
  for (const auto& [aside, along, degrees] :
       {std::array{0.5, 0.5, 0.0}, {0.1, 0.25, 0.0}, {0.3, 0.0, 90.0}, {0.5, 0.5, 30.0}, {0.2, 0.5, 120.0}}) {
    Wounded wounded(aside, along, degrees, params);
    for (int n = 0; n < 75; n++) step(Exec(2), wounded.model, wounded.state, {}, 1.0 / 30);
    const double gape = measure_wound(wounded.model, wounded.state, wounded.path, 0).gape_max;
    std::printf("%.2f aside, %.2f along, %3.0f degrees: %.2f mm\n", aside, along, degrees, 1e3 * gape);
    least = std::min(least, gape), most = std::max(most, gape);
  }
  EXPECT_LT(most - least, 0.06 * most) << "m";
}

// Forces at virtual nodes are the negative gradient of the energy.
TEST(CutElements, VirtualNodeForcesAreGradient) {
  Wounded wounded(0.3, 0.5, 20, solid_params(5, 4, 45));
  const Model& model = wounded.model;
  State& state = wounded.state;
  scatter(model, state, 0.0005);
  const CutElementForces forces(model, state);
  ASSERT_GT(state.cut_elements.virtual_nodes.size(), 20u);
  for (std::size_t n = 0; n < state.cut_elements.virtual_nodes.size(); n += 7) {
    const ElementNode& node = state.cut_elements.virtual_nodes[n];
    VirtualNodeDisplacement& at =
        state.motion.virtual_u[std::size_t(node.corner - slot_count(model.anatomy.lattice))];
    const VirtualNodeDisplacement initial = at;
    const Vec3d force(forces.gather(node).f);
    Vec3d gradient;
    for (Real VirtualNodeDisplacement::*axis :
         {&VirtualNodeDisplacement::x, &VirtualNodeDisplacement::y, &VirtualNodeDisplacement::z}) {
      double energies[2];
      for (const int side : {0, 1}) {
        at = initial;
        at.*axis += side ? 1e-5f : -1e-5f;
        energies[side] = energy(kOne, model, state);
      }
      at = initial;
      gradient[axis == &VirtualNodeDisplacement::x   ? 0
               : axis == &VirtualNodeDisplacement::y ? 1
                                                     : 2] = (energies[1] - energies[0]) / 2e-5;
    }
    EXPECT_LT(norm(gradient + force), 0.01 * norm(gradient) + 1e-6) << "N, virtual node " << n;
  }
}

// VBD sweeps never raise the energy of a step with a wound.
TEST(CutElements, VbdNeverRaisesEnergy) {
  for (const Ordering ordering : {Ordering::kSlabs, Ordering::kColors}) {
    Params params = solid_params(5, 4, 45);
    params.solver.ordering = ordering;
    Wounded wounded(0.3, 0.5, 20, params);
    scatter(wounded.model, wounded.state, 0.0005);
    predict(kOne, wounded.model, wounded.state, {}, 1.0 / 60);
    double before = step_energy(kOne, wounded.model, wounded.state, {}, 1.0 / 60);
    for (int sweep = 0; sweep < 10; sweep++) {
      sweep_vbd(kOne, wounded.model, wounded.state, {}, 1.0 / 60,
                sweep % 2 ? Order::kBackward : Order::kForward);
      const double after = step_energy(kOne, wounded.model, wounded.state, {}, 1.0 / 60);
      EXPECT_LE(after, before * (1 + 1e-6)) << "J, sweep " << sweep << ", ordering " << int(ordering);
      before = after;
    }
  }
}

/// Nodes of one element must differ in color; a virtual node has the color of its node.
void expect_different_colors(const Wounded& wounded, std::span<const int> corners, const char* what) {
  const Lattice& l = wounded.model.anatomy.lattice;
  std::set<int> colors;
  for (const int corner : corners) {
    int slot = corner;
    if (corner >= slot_count(l))
      slot = wounded.state.cut_elements.virtual_node_keys[std::size_t(corner - slot_count(l))].first;
    EXPECT_TRUE(colors.insert(color_of(slot_node(l, slot))).second) << what << ", corner " << corner;
  }
}

// No two nodes or virtual nodes of a color share a cell, a triangle or a cut element.
TEST(CutElements, ElementNodesDifferInColor) {
  for (const double degrees : {20.0, 75.0}) {
    const Wounded wounded(0.3, 0.5, degrees, solid_params(5, 4, 45));
    const Lattice& l = wounded.model.anatomy.lattice;
    int whole = 0;
    for (std::size_t slot = 0; slot < wounded.model.anatomy.cell_young.size(); slot++) {
      if (wounded.model.anatomy.cell_young[slot] <= 0) continue;
      int corners[kCellCorners];
      for (int n = 0; n < kCellCorners; n++)
        corners[n] = node_slot(l, slot_node(l, int(slot)) + cell_corner(n));
      expect_different_colors(wounded, corners, "a cell"), whole++;
    }
    for (const SkinTriangle& t : wounded.model.anatomy.skin.triangles)
      expect_different_colors(wounded, std::array{t.vertex.x, t.vertex.y, t.vertex.z}, "skin");
    for (const CutCellElement& element : wounded.state.cut_elements.cells)
      expect_different_colors(wounded, element.corner, "element of a cut cell");
    for (const CutSkinElement& element : wounded.state.cut_elements.skin)
      expect_different_colors(wounded, std::array{element.corner.x, element.corner.y, element.corner.z},
                              "element of cut skin");
    EXPECT_GT(whole, 3000);
    EXPECT_GT(wounded.state.cut_elements.cells.size(), 50u);
    EXPECT_GT(wounded.state.cut_elements.skin.size(), 10u);
  }
}

// A wound has the same bits for any order of updates within a color.
TEST(CutElements, AnyOrderWithinColorEqualBits) {
  Params params = solid_params(5, 4, 45);
  params.solver.ordering = Ordering::kColors;
  std::set<std::uint64_t> hashes;
  const auto hash_after = [&](const auto& sweep) {
    Wounded wounded(0.3, 0.5, 20, params);
    scatter(wounded.model, wounded.state, 0.0005);
    predict(kOne, wounded.model, wounded.state, {}, 1.0 / 60);
    for (const Order order : {Order::kForward, Order::kBackward}) sweep(wounded, order);
    hashes.insert(state_hash(wounded.model, wounded.state));
  };
  for (const int threads : {1, 2, 8})
    hash_after(
        [&](Wounded& w, Order order) { sweep_vbd(Exec(threads), w.model, w.state, {}, 1.0 / 60, order); });
  for (const unsigned seed : {1u, 2u})
    hash_after([&](Wounded& w, Order order) {
      sweep_vbd_by_colors(ShuffledRun{seed}, w.model, w.state, {}, 1.0 / 60, order);
    });
  EXPECT_EQ(hashes.size(), 1u);
}

// A wound has the same gape at rest by colors and by slabs.
TEST(CutElements, RestingWoundMatchesAcrossOrderings) {
  for (const auto& [aside, degrees] : {std::pair{0.3, 20.0}, {0.2, 110.0}}) {
    double gape[2];
    for (const Ordering ordering : {Ordering::kSlabs, Ordering::kColors}) {
      Params params = solid_params(5, 8, 45);
      params.tissue.poisson = 0.45;
      params.solver.ordering = ordering;
      Wounded wounded(aside, 0.5, degrees, params);
      for (int n = 0; n < 60; n++) step(Exec(2), wounded.model, wounded.state, {}, 1.0 / 30);
      gape[int(ordering)] = measure_wound(wounded.model, wounded.state, wounded.path, 0).gape_max;
    }
    std::printf("%.1f aside, %3.0f degrees: %.4f mm by slabs, %.4f mm by colors\n", aside, degrees,
                1e3 * gape[0], 1e3 * gape[1]);
    EXPECT_NEAR(gape[1], gape[0], 1e-3 * gape[0]) << "m";
  }
}

// A moving blade leaves the same wound as an instant cut.
TEST(CutElements, MovingBladeMatchesInstantCut) {
  const Params params = solid_params(10, 4, 45);
  Wounded at_once(0.3, 0.5, 20, params), moving(0.3, 0.5, 20, params);
  State state = make_state(moving.model);
  for (int n = 0; n < 100; n++) {
    step(kOne, at_once.model, at_once.state, {}, 1.0 / 30);
    if (n < 20) cut_edges(moving.model, state, moving.path, n / 20.0, (n + 1) / 20.0, 0);
    EXPECT_TRUE(step(kOne, moving.model, state, {}, 1.0 / 30).finite);
  }
  EXPECT_EQ(state.cut_elements.cells.size(), at_once.state.cut_elements.cells.size());
  EXPECT_EQ(state.motion.virtual_u.size(), at_once.state.motion.virtual_u.size());
  const double once = measure_wound(at_once.model, at_once.state, at_once.path, 0).gape_max;
  EXPECT_NEAR(measure_wound(moving.model, state, moving.path, 0).gape_max, once, 0.01 * once) << "m";
}

// A wound has the same bits on one, two and eight threads.
TEST(CutElements, EqualBitsOnAnyThreads) {
  std::uint64_t hashes[3];
  for (int n = 0; n < 3; n++) {
    Wounded wounded(0.3, 0.5, 20, solid_params(5, 4, 45));
    for (int frame = 0; frame < 6; frame++)
      step(Exec(n == 0 ? 1 : n == 1 ? 2 : 8), wounded.model, wounded.state, {}, 1.0 / 60);
    hashes[n] = state_hash(wounded.model, wounded.state);
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(hashes[0], hashes[2]);
}

}  // namespace
}  // namespace turgor::lattice
