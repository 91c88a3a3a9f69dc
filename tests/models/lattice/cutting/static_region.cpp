// Static incisions, which remove the nodes of a region.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/lattice/ct_body.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"

namespace turgor::lattice {
namespace {

/// A ball under tense skin that is held below its middle: skin that lost a region pulls a free one along.
struct TenseBall {
  static constexpr double kRadius = 16.3;  // [voxels]
  static constexpr int kSide = 41;         // [voxels]
  static constexpr double kFrame = 1.0 / 60;
  CtVolume ct = ball_ct(kSide, kRadius);
  Model model;
  State state;

  explicit TenseBall(Params params, int block = 3) {
    params.block = {block, block, block};
    BodyNodes nodes = classify(Exec(2), ct, nullptr, params).value();
    for_voxels(nodes.grid, [&](Int3 p) {
      if (2 * p.z < nodes.grid.size.z) nodes.fixed[sample_index(nodes.grid, p.x, p.y, p.z)] = 1;
    });
    model = assemble(Exec(2), nodes, nullptr, params).value();
    state = make_state(model);
  }
  Vec3d on_skin(double x, double y) const {
    constexpr double kMiddle = (kSide - 1) / 2;
    return ct.grid.origin +
           Vec3d{kMiddle + x, kMiddle + y, kMiddle + std::sqrt(kRadius * kRadius - x * x - y * y)} * kVoxel;
  }
  BladePath straight_path() const {
    return lay_blade(model, state,
                     {.from = on_skin(-7, 1), .to = on_skin(7, 1), .depth = 0.006, .width = 0.007})
        .value();
  }
};

Params tense_params(TissueLaw law, Ordering ordering = Ordering::kSlabs, double sleep_speed = 0) {
  Params params;
  params.tissue.law = law;
  params.tissue.poisson = 0.3;
  params.solver = {.ordering = ordering, .sweeps = 6, .damping = 4, .sleep_speed = sleep_speed};
  return params;
}

// In partial cells, rim nodes that a region leaves without a whole cell are removed with it: nothing would
// hold them against the tension that their skin had.
TEST(StaticRegion, LooseRimIsRemoved) {
  Params params = tense_params(TissueLaw::kSolid);
  params.tissue.partial_cells = true;
  params.skin.tension_along = params.skin.tension_across = 1;
  TenseBall ball(params);
  ASSERT_GT(cut_region(ball.model, ball.state, ball.straight_path()), 10);
  for (int n = 0; n < 10; n++)
    ASSERT_TRUE(step(Exec(2), ball.model, ball.state, {}, TenseBall::kFrame).finite);
  const Lattice& l = ball.model.anatomy.lattice;
  int removed = 0, kept = 0;
  double farthest = 0;
  for (int slot = 0; slot < slot_count(l); slot++) {
    const Int3 node = slot_node(l, slot);
    if (!contains(l, node) || node_slot(l, node) != slot || !has_node(ball.model, slot)) continue;
    if (ball.state.cuts.removed[std::size_t(slot)]) {
      removed += is_rim(ball.model, slot);
      continue;
    }
    farthest = std::max(farthest, double(norm(ball.state.motion.u[std::size_t(slot)])));
    if (!is_rim(ball.model, slot)) continue;
    bool is_held = false;
    for (int c = 0; c < kCellCorners; c++)
      is_held = is_held || is_whole_cell(ball.model, ball.state.cuts, node - cell_corner(c));
    EXPECT_TRUE(is_held) << "rim node at " << node.x << ' ' << node.y << ' ' << node.z;
    kept++;
  }
  EXPECT_GT(removed, 5);
  EXPECT_GT(kept, 100);
  EXPECT_LT(farthest, 2 * 3 * kVoxel) << "two spacings: soft corners of cells that are almost empty";
}

}  // namespace
}  // namespace turgor::lattice
