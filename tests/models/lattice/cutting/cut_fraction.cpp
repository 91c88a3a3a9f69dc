// The cut fraction of partially cut cells, and its effect on wounds.
#include "turgor/models/lattice/cutting/cut_fraction.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/lattice/wounded_block.hpp"
#include "turgor/models/lattice/mechanics/cut_elements.hpp"

namespace turgor::lattice {
namespace {

constexpr double kStep = 0.004;

/// 17 × 17 × 7 nodes, fixed at the sides and the bottom; the fine lattice halves the cells.
Model small_block(Params params) {
  constexpr int kN = 17;
  params.block = {2, 2, 2};
  return block_model(
      {.size = {kN, kN, 7},
       .spacing = kStep,
       .young = 5e3,
       .is_fixed = [](Int3 p) { return p.x == 0 || p.y == 0 || p.z == 0 || p.x == kN - 1 || p.y == kN - 1; }},
      params);
}
/// Position on the skin, arguments in cells.
Vec3d on_skin(double x, double y) { return {x * kStep, y * kStep, 6 * kStep}; }

/// Cut fractions at the crack tips of selected cells, smallest and largest.
struct Found {
  double least = 1, most = 0;
  int count = 0;
};
template <class Selected>
Found fractions_where(const Model& model, const State& state, const Selected& selected) {
  const Fragments fragments = make_fragments(model, state.cuts);
  Found found;
  for (const CutCell& cell : fragments.cells)
    for (int t = cell.first_tip; t < cell.first_tip + cell.tip_count; t++) {
      if (!selected(slot_node(model.anatomy.lattice, cell.slot))) continue;
      const double fraction = cut_fraction(state.cuts, fragments, cell, fragments.tips[std::size_t(t)]);
      found.least = std::min(found.least, fraction), found.most = std::max(found.most, fraction),
      found.count++;
    }
  return found;
}

// The cut fraction of a cell is the cut area of its section for blades along the axes.
TEST(CutFraction, MatchesAxisAlignedSection) {
  const Model model = small_block(solid_params(5, 4, 45));
  for (const double end : {0.1, 0.3, 0.55, 0.8, 0.95})
    for (const bool turned : {false, true}) {
      State state = make_state(model);
      const Vec3d from = turned ? on_skin(8.3, 3.5) : on_skin(3.5, 8.3),
                  to = turned ? on_skin(8.3, 10 + end) : on_skin(10 + end, 8.3);
      const BladePath path =
          lay_blade(model, state, {.from = from, .to = to, .depth = (2 + end) * kStep}).value();
      cut_edges(model, state, path, 0, 1, 0);
      const Found last = fractions_where(
          model, state, [&](Int3 cell) { return cell.z == 5 && (turned ? cell.y : cell.x) == 10; });
      EXPECT_EQ(last.count, 1);
      EXPECT_NEAR(last.most, end, 1.0 / kLineGrid) << "of the section, at its end";
      const Found bottom = fractions_where(model, state, [&](Int3 cell) {
        const int along = turned ? cell.y : cell.x;
        return cell.z == 3 && along > 4 && along < 9;
      });
      EXPECT_EQ(bottom.count, 4);
      EXPECT_NEAR(bottom.least, end, 1.0 / kLineGrid) << "of the section, at its bottom";
      EXPECT_NEAR(bottom.most, end, 1.0 / kLineGrid) << "of the section, at its bottom";
    }
}

// The cut fraction of an oblique section is the area that the blade has reached.
TEST(CutFraction, MatchesObliqueSection) {
  const Model model = small_block(solid_params(5, 4, 45));
  constexpr double kSlope = 0.45,
                   kEnters = 3.5 + 2.8 / kSlope;  // from this x on, the blade is in cells with y = 8
  static_assert(kEnters > 9.7 && kEnters < 9.75);
  for (const double x : {9.15, 9.45, 9.6, 9.95}) {
    State state = make_state(model);
    const BladePath path =
        lay_blade(model, state, {.from = on_skin(3.5, 5.2), .to = on_skin(x, 5.2 + kSlope * (x - 3.5))})
            .value();
    cut_edges(model, state, path, 0, 1, 0);
    const int y = x > kEnters ? 8 : 7;
    const double fraction = x > kEnters ? (x - kEnters) / (10 - kEnters) : (x - 9) / (kEnters - 9);
    const Found found =
        fractions_where(model, state, [y](Int3 cell) { return cell.z == 5 && cell.x == 9 && cell.y == y; });
    ASSERT_EQ(found.count, 1) << "blade to x = " << x;
    EXPECT_NEAR(found.most, fraction, 0.2) << "of the section, blade to x = " << x;
  }
}

double settled_gape(double length) {
  Params params = solid_params(10, 4, 45);
  const Model model = small_block(params);
  State state = make_state(model);
  const BladePath path =
      lay_blade(model, state, {.from = on_skin(8.5 - length / 2, 8.3), .to = on_skin(8.5 + length / 2, 8.3)})
          .value();
  cut_edges(model, state, path, 0, 1, 0);
  for (int n = 0; n < 60; n++) step(Exec(2), model, state, {}, 1.0 / 30);
  return measure_wound(model, state, path, 0).gape_max;
}

// A wound grows continuously while the blade advances within a cell.
TEST(CutFraction, WoundGrowsWithinCell) {
  double last = settled_gape(7.1);  // both ends move from 0.05 to 0.25 of the last cells
  for (const double length : {7.3, 7.5}) {
    const double gape = settled_gape(length);
    EXPECT_GT(gape, last * 1.01) << "m, blade of " << length << " cells";
    EXPECT_LT(gape, last * 1.06) << "m, blade of " << length << " cells";
    last = gape;
  }
}

/// Gapes of a T: a cut through nodes, and one that starts in the skin and ends on the first, `aside` cells
/// beside nodes.
std::array<double, 2> gapes_of_t(double aside) {
  const Model model = small_block(solid_params(10, 4, 45));
  State state = make_state(model);
  const auto settle = [&](int frames) {
    for (int n = 0; n < frames; n++) step(Exec(2), model, state, {}, 1.0 / 30);
  };
  const BladePath across = lay_blade(model, state, {.from = on_skin(3.6, 9), .to = on_skin(12.4, 9)}).value();
  cut_edges(model, state, across, 0, 1, 0);
  settle(30);
  const BladePath upright =
      lay_blade(model, state, {.from = on_skin(8 + aside, 3.6), .to = on_skin(8 + aside, 9)}).value();
  cut_edges(model, state, upright, 0, 1, 1);
  settle(60);
  return {measure_wound(model, state, across, 0).gape_max, measure_wound(model, state, upright, 1).gape_max};
}

// The gape of a T is continuous as its stem moves across nodes.
TEST(CutFraction, GapeIsContinuousAcrossNodes) {
  const auto beside = gapes_of_t(0.05);
  for (const double aside : {-2e-3, -2e-4, 0.0, 2e-4, 2e-3}) {
    const auto gapes = gapes_of_t(aside);
    std::printf("%+.4f cells aside: %.3f and %.3f mm\n", aside, 1e3 * gapes[0], 1e3 * gapes[1]);
    EXPECT_NEAR(gapes[0], beside[0], 0.03 * beside[0]) << aside << " cells aside";
    EXPECT_NEAR(gapes[1], beside[1], 0.03 * beside[1]) << aside << " cells aside";
  }
}

// A blade that advances within a cell wakes the sleeping rows around it.
TEST(CutFraction, AdvancingBladeWakesRows) {
  Params params = solid_params(5, 4, 45);
  double gapes[2];
  for (const bool sleeps : {false, true}) {
    params.solver.sleep_speed = sleeps ? 1e-3 : 0;
    const Model model = small_block(params);
    State state = make_state(model);
    const BladePath path =
        lay_blade(model, state, {.from = on_skin(4.4, 8.3), .to = on_skin(11.4, 8.3)}).value();
    int most = 0;
    double done = 0;
    for (const double to : {6.15 / 7, 6.3 / 7}) {  // from 0.55 to 0.7 of a cell: no edge lies between
      const std::size_t edges = state.cuts.edges.size();
      const int lines = state.cuts.sample_count;
      cut_edges(model, state, path, done, to, 0);
      EXPECT_EQ(state.cuts.edges.size() == edges, done > 0);
      EXPECT_GT(state.cuts.sample_count, lines);
      done = to;
      for (int n = 0; n < 200; n++) {
        const StepReport report = step(Exec(2), model, state, {}, 1.0 / 60);
        if (n == 0) most = report.rows - report.rows_asleep;
        if (n == 199 && sleeps) {
          EXPECT_EQ(report.rows_asleep, report.rows);
        }
      }
      if (sleeps) {
        EXPECT_GT(most, 0) << "rows awake when the blade has gone on";
      }
    }
    gapes[sleeps] = measure_wound(model, state, path, 0).gape_max;
  }
  EXPECT_NEAR(gapes[1], gapes[0], 2e-3 * gapes[0]) << "m";
}

}  // namespace
}  // namespace turgor::lattice
