// A bar under tense skin that is cut through and sewn, for tests of stitches.
#pragma once

#include <gtest/gtest.h>

#include "tests/models/lattice/wounded_block.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/suture/closure.hpp"

namespace turgor::lattice {

/// A bar under tense skin, fixed at both ends and cut through in its middle.
struct HalfBodies {
  static constexpr double kCell = 0.004, kFrameTime = 1.0 / 60;  // [m] [s]
  Model model;
  State state;
  BladePath path;

  HalfBodies(Int3 size, double tension, double damping = 2) {
    Params params = solid_params(5, damping, tension);
    params.tissue.poisson = 0.45;
    Block block{.size = size, .spacing = kCell, .young = 1e4};
    block.is_fixed = [size](Int3 p) { return p.x == 0 || p.x == size.x - 1; };
    model = block_model(block, params);
    state = make_state(model);
    const double x = (size.x / 2 + 0.37) * kCell, z = (size.z - 1) * kCell;
    const Incision blade{.from = {x, 0, z}, .to = {x, (size.y - 1) * kCell, z}, .depth = size.z * kCell};
    path = lay_blade(model, state, blade).value();
    EXPECT_GT(cut_edges(model, state, path, 0, 1, 0), 100);
  }
  WoundClosure stitched(double spacing) const {
    WoundClosure closure = lay_stitches(model, state.cuts, path, {.spacing = spacing}).value();
    closure.thread = {.stiffness = 100, .strength = 20}, closure.pull_out = 20;
    return closure;
  }
};

/// Steps a body with a closure; `time` is that of the last step [s].
inline void sew(const Exec& exec, const Model& model, State& state, const Pull& pull, int steps, double& time,
                WoundClosure& closure) {
  for (int n = 0; n < steps; n++) {
    time += HalfBodies::kFrameTime;
    pull_stitches(state.motion, pull, time, closure);
    PointSprings springs;
    append_springs(closure, springs.all);
    make_terms(springs);
    springs.refresh = [&](const State& now) { update_springs(model, now.motion, closure, springs.all); };
    ASSERT_TRUE(step(exec, model, state, {.springs = &springs}, HalfBodies::kFrameTime).finite);
    update_multipliers(model, state.motion, closure);
    end_overloaded_stitches(state.motion, time, closure);
  }
}

/// Kinetic energy of the nodes of a body [J].
inline double kinetic_energy(const Model& model, const Motion& motion) {
  double sum = 0;
  for (std::size_t s = 0; s < motion.u.x.size(); s++)
    if (const double w = double(model.anatomy.inverse_mass[s]); w > 0)
      sum += 0.5 / w * dot(Vec3d(motion.v[s]), Vec3d(motion.v[s]));
  return sum;
}

}  // namespace turgor::lattice
