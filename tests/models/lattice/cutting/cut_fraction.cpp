// How far into a cell a blade went, and what that does to a wound.
#include "turgor/models/lattice/cutting/cut_fraction.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/lattice/wounded_block.hpp"
#include "turgor/models/lattice/mechanics/cut_elements.hpp"

namespace turgor::lattice {
namespace {

constexpr double kStep = 0.004;

/// 17 × 17 × 7 nodes, held at its sides and below; the fine lattice halves its cells.
Model small_block(Params params) {
  constexpr int kN = 17;
  params.block = {2, 2, 2};
  return block_model(
      {.size = {kN, kN, 7},
       .step = kStep,
       .young = 5e3,
       .is_fixed = [](Int3 p) { return p.x == 0 || p.y == 0 || p.z == 0 || p.x == kN - 1 || p.y == kN - 1; }},
      params);
}
/// A place on its skin [steps].
Vec3d on_skin(double x, double y) { return {x * kStep, y * kStep, 6 * kStep}; }

/// Shares of the tips in cells of one layer, largest and smallest.
struct Found {
  double least = 1, most = 0;
  int count = 0;
};
template <class Wanted>
Found shares_where(const Model& model, const State& state, const Wanted& wanted) {
  const Fragments pieces = make_fragments(model, state);
  Found found;
  for (const CutCell& cell : pieces.cells)
    for (int t = cell.first_tip; t < cell.first_tip + cell.tip_count; t++) {
      if (!wanted(slot_node(model.lattice, cell.slot))) continue;
      const double share = cut_fraction(state, pieces, cell, pieces.tips[std::size_t(t)]);
      found.least = std::min(found.least, share), found.most = std::max(found.most, share), found.count++;
    }
  return found;
}

TEST(lattice_crossed_lines, the_share_of_a_cell_that_a_blade_went_through_is_that_of_its_section) {
  const Model model = small_block(solid_params(5, 4, 45));
  for (const double end : {0.1, 0.3, 0.55, 0.8, 0.95})
    for (const bool turned : {false, true}) {
      State state = make_state(model);
      const Vec3d from = turned ? on_skin(8.3, 3.5) : on_skin(3.5, 8.3),
                  to = turned ? on_skin(8.3, 10 + end) : on_skin(10 + end, 8.3);
      const BladePath path =
          lay_blade(model, state, {.from = from, .to = to, .depth = (2 + end) * kStep}).value();
      cut_edges(model, state, path, 0, 1, 0);
      const Found last = shares_where(
          model, state, [&](Int3 cell) { return cell.z == 5 && (turned ? cell.y : cell.x) == 10; });
      EXPECT_EQ(last.count, 1);
      EXPECT_NEAR(last.most, end, 1.0 / kLineGrid) << "of the section, at its end";
      const Found bottom = shares_where(model, state, [&](Int3 cell) {
        const int along = turned ? cell.y : cell.x;
        return cell.z == 3 && along > 4 && along < 9;
      });
      EXPECT_EQ(bottom.count, 4);
      EXPECT_NEAR(bottom.least, end, 1.0 / kLineGrid) << "of the section, at its bottom";
      EXPECT_NEAR(bottom.most, end, 1.0 / kLineGrid) << "of the section, at its bottom";
    }
}

TEST(lattice_crossed_lines, of_a_section_aslant_the_share_is_the_part_that_the_blade_reached) {
  const Model model = small_block(solid_params(5, 4, 45));
  constexpr double kSlope = 0.45, kEnters = 3.5 + 2.8 / kSlope;  // the blade goes into cells with y = 8 here
  static_assert(kEnters > 9.7 && kEnters < 9.75);
  for (const double x : {9.15, 9.45, 9.6, 9.95}) {
    State state = make_state(model);
    const BladePath path =
        lay_blade(model, state, {.from = on_skin(3.5, 5.2), .to = on_skin(x, 5.2 + kSlope * (x - 3.5))})
            .value();
    cut_edges(model, state, path, 0, 1, 0);
    const int y = x > kEnters ? 8 : 7;
    const double share = x > kEnters ? (x - kEnters) / (10 - kEnters) : (x - 9) / (kEnters - 9);
    const Found found =
        shares_where(model, state, [y](Int3 cell) { return cell.z == 5 && cell.x == 9 && cell.y == y; });
    ASSERT_EQ(found.count, 1) << "blade to x = " << x;
    EXPECT_NEAR(found.most, share, 0.2) << "of the section, blade to x = " << x;
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

TEST(lattice_crossed_lines, a_wound_grows_as_its_blade_goes_on_in_a_cell) {
  double last = settled_gape(7.1);  // both ends go from 0.05 to 0.25 into the last cells
  for (const double length : {7.3, 7.5}) {
    const double gape = settled_gape(length);
    EXPECT_GT(gape, last * 1.01) << "m, blade of " << length << " steps";
    EXPECT_LT(gape, last * 1.06) << "m, blade of " << length << " steps";
    last = gape;
  }
}

/// A cut through nodes, and one that begins in the skin and ends on it, `aside` steps beside nodes; gapes of
/// both.
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

TEST(lattice_crossed_lines, a_t_gapes_alike_on_both_sides_of_nodes_that_its_stem_goes_through) {
  const auto beside = gapes_of_t(0.05);
  for (const double aside : {-2e-3, -2e-4, 0.0, 2e-4, 2e-3}) {
    const auto gapes = gapes_of_t(aside);
    std::printf("%+.4f steps aside: %.3f and %.3f mm\n", aside, 1e3 * gapes[0], 1e3 * gapes[1]);
    EXPECT_NEAR(gapes[0], beside[0], 0.03 * beside[0]) << aside << " steps aside";
    EXPECT_NEAR(gapes[1], beside[1], 0.03 * beside[1]) << aside << " steps aside";
  }
}

TEST(lattice_crossed_lines, a_blade_that_creeps_on_wakes_what_sleeps_around_it) {
  Params params = solid_params(5, 4, 45);
  double gapes[2];
  for (const bool sleeps : {false, true}) {
    params.solver.sleep = sleeps ? 1e-3 : 0;
    const Model model = small_block(params);
    State state = make_state(model);
    const BladePath path =
        lay_blade(model, state, {.from = on_skin(4.4, 8.3), .to = on_skin(11.4, 8.3)}).value();
    int most = 0;
    double done = 0;
    for (const double to : {6.15 / 7, 6.3 / 7}) {  // from 0.55 to 0.7 of a cell: no edge lies between
      const std::size_t edges = state.cut_edges.size();
      const int lines = state.cut_sample_count;
      cut_edges(model, state, path, done, to, 0);
      EXPECT_EQ(state.cut_edges.size() == edges, done > 0);
      EXPECT_GT(state.cut_sample_count, lines);
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
