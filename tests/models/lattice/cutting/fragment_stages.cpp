// Fragments of a moving blade, which reuse those of earlier cuts, against fragments from the beginning.
#include "turgor/models/lattice/cutting/fragment_stages.hpp"

#include <random>

#include <gtest/gtest.h>

#include "tests/models/lattice/ct_body.hpp"
#include "tests/models/lattice/wounded_block.hpp"

namespace turgor::lattice {
namespace {

/// A ball of solid tissue whose skin lies between nodes.
struct SolidBall {
  CtVolume ct = blurred_ball_ct(48, 18, false);
  Model model;
  State state;

  SolidBall() {
    Params params = solid_params(5, 4, 45);
    params.block = {3, 3, 4};
    model = build(Exec(1), ct, {}, params).value();
    state = make_state(model);
  }
  Vec3d on_skin(double x, double y) const {
    return ct.grid.origin + (Vec3d{23.5, 23.5, 23.5} + Vec3d{x, y, std::sqrt(324 - x * x - y * y)}) * kVoxel;
  }
};

void expect_same_cells(const Fragments& found, const Fragments& fresh) {
  ASSERT_EQ(found.cells.size(), fresh.cells.size());
  for (std::size_t c = 0; c < fresh.cells.size(); c++) {
    const CutCell &a = found.cells[c], &b = fresh.cells[c];
    ASSERT_EQ(a.slot, b.slot);
    ASSERT_EQ(a.first_fragment, b.first_fragment);
    ASSERT_EQ(a.fragment_count, b.fragment_count);
    ASSERT_EQ(a.is_cut, b.is_cut);
    ASSERT_EQ(a.tip_count, b.tip_count);
    ASSERT_EQ(a.first_ghost, b.first_ghost);
    ASSERT_EQ(a.ghost_count, b.ghost_count);
  }
  ASSERT_EQ(found.label, fresh.label);
  ASSERT_EQ(found.cut_bits, fresh.cut_bits);
  ASSERT_EQ(found.tips.size(), fresh.tips.size());
  for (std::size_t t = 0; t < fresh.tips.size(); t++) {
    ASSERT_EQ(found.tips[t].plane.center, fresh.tips[t].plane.center);
    ASSERT_EQ(found.tips[t].plane.normal, fresh.tips[t].plane.normal);
    ASSERT_EQ(found.tips[t].left, fresh.tips[t].left);
    ASSERT_EQ(found.tips[t].right, fresh.tips[t].right);
  }
}

void expect_same_virtual_nodes(const Fragments& found, const Fragments& fresh) {
  ASSERT_EQ(found.all.size(), fresh.all.size());
  for (std::size_t p = 0; p < fresh.all.size(); p++) {
    ASSERT_EQ(found.all[p].cell, fresh.all[p].cell);
    ASSERT_EQ(found.all[p].lowest_node, fresh.all[p].lowest_node);
    ASSERT_EQ(found.all[p].thin, fresh.all[p].thin);
    ASSERT_EQ(found.all[p].corner, fresh.all[p].corner);
  }
  ASSERT_EQ(found.virtual_nodes.size(), fresh.virtual_nodes.size());
  for (std::size_t n = 0; n < fresh.virtual_nodes.size(); n++) {
    ASSERT_EQ(found.virtual_nodes[n].slot, fresh.virtual_nodes[n].slot);
    ASSERT_EQ(found.virtual_nodes[n].lowest_node, fresh.virtual_nodes[n].lowest_node);
    ASSERT_EQ(found.virtual_nodes[n].has_unknowns, fresh.virtual_nodes[n].has_unknowns);
    ASSERT_EQ(found.virtual_nodes[n].term_count, fresh.virtual_nodes[n].term_count);
  }
  ASSERT_EQ(found.fit_terms.size(), fresh.fit_terms.size());
  for (std::size_t t = 0; t < fresh.fit_terms.size(); t++) {
    ASSERT_EQ(found.fit_terms[t].corner, fresh.fit_terms[t].corner);
    ASSERT_EQ(found.fit_terms[t].weight, fresh.fit_terms[t].weight);
  }
}

// After every step of random blades that cross each other, fragments have the bits of fresh ones.
TEST(FragmentStages, MovingBladesMatchFreshFragments) {
  std::mt19937 random(19);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int body = 0; body < 2; body++) {
    SolidBall ball;
    for (int blade = 0; blade < 4; blade++) {
      const auto end = [&] { return ball.on_skin(11 * any(random), 11 * any(random)); };
      const Incision incision{
          .from = end(), .to = end(), .depth = 0.008 + 0.003 * any(random), .tilt = 30 * any(random)};
      const BladePath path = lay_blade(ball.model, ball.state, incision).value();
      double done = 0;
      for (int frame = 0; frame < 7; frame++) {
        const double next = frame == 6 ? 1 : std::min(1.0, done + 0.16 * (1.1 + any(random)));
        cut_edges(ball.model, ball.state, path, done, next, blade);
        done = next;
        const Fragments fresh = make_fragments(ball.model, ball.state.cuts);
        expect_same_cells(*ball.state.cuts.fragments, fresh);
        expect_same_virtual_nodes(*ball.state.cuts.fragments, fresh);
        if (HasFatalFailure()) return;
      }
    }
  }
}

// Far from a blade that goes on, cells are taken from earlier fragments. Fragments of other cuts are not
// used.
TEST(FragmentStages, OnlyCellsNearTheBladeChange) {
  SolidBall ball;
  const BladePath path =
      lay_blade(ball.model, ball.state, {.from = ball.on_skin(-12, 0), .to = ball.on_skin(12, 0)}).value();
  cut_edges(ball.model, ball.state, path, 0, 0.8, 0);
  const std::shared_ptr<const Fragments> before = ball.state.cuts.fragments;
  cut_edges(ball.model, ball.state, path, 0.8, 0.82, 0);
  const auto kept = [&](const Cuts& cuts) {
    Fragments again = make_fragments(ball.model, cuts);
    again.stages = {};
    const EarlierFragments earlier = find_earlier(before.get(), cuts, again);
    return std::count_if(earlier.cell.begin(), earlier.cell.end(), [](int index) { return index >= 0; });
  };
  EXPECT_GT(kept(ball.state.cuts), std::ptrdiff_t(before->cells.size() / 2));
  Cuts other = ball.state.cuts;
  other.edges[5].fraction *= Real(0.5);
  EXPECT_EQ(kept(other), 0);
}

}  // namespace
}  // namespace turgor::lattice
