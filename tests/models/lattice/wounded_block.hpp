// A block of solid tissue under tense skin with a cut in its middle, for tests of cut elements and coarse
// spaces.
#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "turgor/models/lattice/build/block_body.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

inline Params solid_params(int sweeps, double damping, double tension) {
  Params params;
  params.tissue = {.law = TissueLaw::kSolid, .poisson = 0.3};
  params.skin.tension_along = params.skin.tension_across = tension;
  params.solver = {.sweeps = sweeps, .damping = damping};
  return params;
}

/// A block of tissue under tense skin with a cut in its middle.
struct Wounded {
  static constexpr double kStep = 0.004;
  static constexpr int kN = 25;
  Model model;
  State state;
  BladePath path;

  Wounded(double aside, double along, double degrees, Params params) {
    Block block{.size = {kN, kN, 7}, .spacing = kStep, .young = 5e3};
    block.is_fixed = [](Int3 p) {
      return p.x == 0 || p.y == 0 || p.z == 0 || p.x == kN - 1 || p.y == kN - 1;
    };
    const double angle = degrees * std::numbers::pi / 180;
    const Vec3d line{std::cos(angle), std::sin(angle), 0};
    params.skin.direction = line;
    model = block_model(block, params);
    state = make_state(model);
    const Vec3d middle{(12 + along) * kStep, (12 + aside) * kStep, 6 * kStep};
    path = lay_blade(model, state, {.from = middle - line * 0.018, .to = middle + line * 0.018}).value();
    cut_edges(model, state, path, 0, 1, 0);
  }
};

/// Random displacements of nodes and virtual nodes.
inline void scatter(const Model& model, State& state, double amplitude) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> any(-float(amplitude), float(amplitude));
  for (std::size_t s = 0; s < model.anatomy.inverse_mass.size(); s++)
    if (model.anatomy.inverse_mass[s] > 0) state.motion.u.set(s, {any(random), any(random), any(random)});
  for (VirtualNodeDisplacement& c : state.motion.virtual_u) c = {any(random), any(random), any(random)};
  state.motion.u_before = state.motion.u;
}

}  // namespace turgor::lattice
