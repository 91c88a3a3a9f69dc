// A ball from a CT with a wound, for tests of its deformed CT on the host and on devices.
#pragma once

#include <gtest/gtest.h>

#include "tests/models/lattice/ct_body.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

/// A tense ball of 1 mm voxels with a T-shaped cut, its second blade tilted, after some steps.
struct CutBall {
  CtVolume ct = ball_ct(33, 12.3);
  Model model;
  State state;

  explicit CutBall(SolverParams solver, TissueLaw law = TissueLaw::kSprings, Int3 block = {3, 3, 3}) {
    Params params;
    params.block = block;
    params.solver = solver;
    params.solver.ordering = Ordering::kColors, params.solver.coarse = false;
    params.tissue.law = law;
    model = build(Exec(1), ct, {}, params).value();
    state = make_state(model);
    cut({-7, 0, 0}, {7, 0, 0}, 0), cut({0, 0.5, 0}, {0, 8, 0}, 35);
    const Inputs inputs{.gravity = {0.5, 0, -9.81}};
    for (int n = 0; n < 5; n++) EXPECT_TRUE(step(Exec(1), model, state, inputs, 2e-3).finite);
  }
  /// Along a line on the top, relative to the axis of the ball [voxels].
  BladePath path(Vec3d from, Vec3d to, double tilt, double width) const {
    const auto on_skin = [&](Vec3d p) {
      return ct.grid.origin + (Vec3d{16, 16, 16} + Vec3d{p.x, p.y, std::sqrt(150 - dot(p, p))}) * kVoxel;
    };
    return lay_blade(model, state,
                     {.from = on_skin(from), .to = on_skin(to), .depth = 0.008, .tilt = tilt, .width = width})
        .value();
  }
  void cut(Vec3d from, Vec3d to, double tilt) {
    EXPECT_GT(cut_edges(model, state, path(from, to, tilt, 0), 0, 1, 0), 10);
  }
};

}  // namespace turgor::lattice
