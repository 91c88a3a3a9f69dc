// Static incisions, which remove the nodes of a region: what they remove, and that nothing of it moves.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/models/host_backend.hpp"
#include "tests/models/lattice/ct_body.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/device/device_state.hpp"
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

/// Displacements of the removed nodes [m].
std::vector<Vec3> removed_displacements(const State& state) {
  std::vector<Vec3> u;
  for (std::size_t s = 0; s < state.cuts.removed.size(); s++)
    if (state.cuts.removed[s]) u.push_back(state.motion.u[s]);
  return u;
}

// The nodes inside half the width, the depth and the length of a curved path in a deformed body are removed,
// and no others.
TEST(StaticRegion, RemovesNodesOfRegion) {
  constexpr int kBlock = 2;
  TenseBall ball(tense_params(TissueLaw::kSprings), kBlock);
  move(ball.model, ball.state, [](Vec3d x) { return wobble(x, 0.0008, 0.03, 0.4); });
  for (const double width : {0.002, 0.009}) {
    State state = ball.state;
    const BladePath path =
        lay_blade(
            ball.model, state,
            {.path = {ball.on_skin(-9, -3), ball.on_skin(-3, 4), ball.on_skin(3, 3), ball.on_skin(8, -5)},
             .depth = 0.012,
             .width = width})
            .value();
    // every node against every point of the path
    const Lattice& l = ball.model.anatomy.lattice;
    const double length = path_length(path), above = 2 * kBlock * kVoxel;
    std::vector<int> expected, found;
    for (int k = 0; k < l.size.z; k++)
      for (int j = 0; j < l.size.y; j++)
        for (int i = 0; i < l.size.x; i++) {
          const int slot = node_slot(l, i, j, k);
          if (!is_body(ball.model.anatomy.tissue[std::size_t(slot)])) continue;
          const Vec3d x(position(ball.model, state.motion, {i, j, k}));
          double nearest = 1e9, before = 0, along = 0, across = 0, depth = 0, bottom = 0;
          for (std::size_t n = 0; n < path.points.size(); n++) {
            if (n > 0) before += norm(path.points[n] - path.points[n - 1]);
            const Vec3d away = x - path.points[n], inward = path.inward[n];
            const double distance = norm(cross(away, inward));
            if (!(distance < nearest)) continue;
            nearest = distance, depth = dot(away, inward), bottom = path.depths[n];
            across = dot(away, across_at(path, n)), along = before + dot(away, tangent_at(path, n));
          }
          if (std::abs(across) <= 0.5 * width && along >= 0 && along <= length && depth >= -above &&
              depth <= bottom)
            expected.push_back(slot);
        }
    EXPECT_EQ(cut_region(ball.model, state, path), int(expected.size()));
    for (std::size_t s = 0; s < state.cuts.removed.size(); s++)
      if (state.cuts.removed[s]) found.push_back(int(s));
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(found, expected) << "width " << width;
    EXPECT_GT(found.size(), 10U) << "width " << width;
    EXPECT_GT(path.points.size(), 16U) << "more than one box of the search";
  }
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

// Removed nodes have no tissue, but those of curved skin had its tension. They stay, and the body falls
// asleep.
TEST(StaticRegion, RemovedNodesStayAndSleep) {
  for (const int variant : {0, 1, 2, 3}) {
    Params params = tense_params(variant < 2 ? TissueLaw::kSprings : TissueLaw::kSolid,
                                 variant == 1 ? Ordering::kColors : Ordering::kSlabs, 1e-4);
    if (variant == 3) params.tissue.energy = SolidEnergy::kExponential, params.tissue.stiffening = 4;
    TenseBall ball(params);
    ASSERT_GT(cut_region(ball.model, ball.state, ball.straight_path()), 10);
    const std::vector<Vec3> before = removed_displacements(ball.state);
    StepReport report;
    for (int n = 0; n < 10; n++) report = step(Exec(2), ball.model, ball.state, {}, TenseBall::kFrame);
    EXPECT_TRUE(removed_displacements(ball.state) == before) << "variant " << variant;
    for (int n = 0; n < 400 && report.rows_asleep < report.rows; n++)
      report = step(Exec(2), ball.model, ball.state, {}, TenseBall::kFrame);
    EXPECT_TRUE(report.finite);
    EXPECT_EQ(report.rows_asleep, report.rows) << "variant " << variant;
  }
}

// The same in the kernels of a device.
TEST(StaticRegion, RemovedNodesStayOnDevice) {
  for (const TissueLaw law : {TissueLaw::kSprings, TissueLaw::kSolid}) {
    Params params = tense_params(law, Ordering::kColors);
    params.solver.coarse = false;
    TenseBall ball(params);
    const BladePath path = ball.straight_path();
    DeviceState state = std::move(ball.state);
    state.use_backend(put_on_host<ThreadedRun<1>>(ball.model));
    ASSERT_GT(state.cut_region(ball.model, path), 10);
    const std::vector<Vec3> before = removed_displacements(*state);
    for (int n = 0; n < 10; n++) ASSERT_TRUE(state.step(Exec(1), ball.model, {}, TenseBall::kFrame).finite);
    EXPECT_TRUE(removed_displacements(*state) == before);
    EXPECT_GT(state->motion.fastest, 0);
  }
}

}  // namespace
}  // namespace turgor::lattice
