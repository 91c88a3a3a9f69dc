// A block of tissue in a lattice, pressed by a tool, for tests of contact.
#pragma once

#include <algorithm>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/contact/lattice_touch.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::contact {

using lattice::Block;
using lattice::Model;
using lattice::State;

constexpr double kDt = 1.0 / 60, kYoung = 4e3;

/// A block of tissue with air above, fixed at its bottom; the skin, if any, has no tension. `young`: modulus
/// at a position, if it is not the same everywhere [Pa].
struct Pressed {
  Model model;
  State state;
  double top = 0;  // of its surface [m]
  LatticeTouch touch;
  std::vector<Tool> tools;
  std::vector<ToolForce> forces;
  std::vector<ToolPose> at;

  Pressed(Int3 size, double step, int sweeps, Tool tool, Vec3d from, bool with_skin = false,
          const lattice::TissueParams& tissue = {}, const std::function<double(Vec3d)>& young = {}) {
    lattice::Params params;
    params.tissue = tissue;
    params.skin.enabled = with_skin;
    params.skin.tension_along = params.skin.tension_across = 0;
    params.solver = {.sweeps = sweeps, .damping = 8};
    const Block block{
        .size = size, .spacing = step, .young = kYoung, .is_fixed = [](Int3 p) { return p.z == 0; }};
    lattice::BodyNodes nodes = lattice::block_nodes(block);
    const auto nx = std::size_t(nodes.grid.size.x), ny = std::size_t(nodes.grid.size.y);
    for (std::size_t n = 0; young && n < nodes.young.size(); n++)
      if (nodes.young[n] > 0)
        nodes.young[n] =
            float(young(Vec3d{double(n % nx), double(n / nx % ny), double(n / (nx * ny))} * step));
    params.skin.enabled = with_skin;
    model = lattice::assemble(Exec(1), std::move(nodes), nullptr, params).value();
    state = lattice::make_state(model);
    const lattice::BodySurface surface = lattice::build_surface(model, state.cuts);
    for (const Vec3 x : surface.rest) top = std::max(top, double(x.z));
    tools = {std::move(tool)};
    at = {{{from, {}}, false}};
    forces.resize(1);
    touch = make_lattice_touch(model, state.cuts, surface, at);
  }

  /// Moves the first tool in equal steps; returns the force on it after each.
  std::vector<Vec3d> move_to(const Exec& exec, Vec3d to, int steps, bool hold = false) {
    std::vector<Vec3d> forces_on_tool;
    const Vec3d from = at[0].pose.position;
    for (int n = 1; n <= steps; n++) {
      at[0] = {{from + (to - from) * (double(n) / steps), {}}, hold};
      EXPECT_TRUE(contact::step_with_tools(exec, model, state, touch, tools, at, {}, kDt, forces).finite);
      forces_on_tool.push_back(forces[0].force);
    }
    return forces_on_tool;
  }
};

/// Center of the block's top.
inline Vec3d middle(Int3 size, double step, double height) {
  return {0.5 * (size.x - 1) * step, 0.5 * (size.y - 1) * step, height};
}

/// Reaction along z at the fixed nodes: the slope of the elastic energy when they move together [N].
inline double reaction(const Pressed& block) {
  double energies[2];
  constexpr Real kShift = 2e-5f;
  for (const int side : {0, 1}) {
    State state = block.state;
    for (int j = 0; j < block.model.anatomy.lattice.size.y; j++)
      for (int i = 0; i < block.model.anatomy.lattice.size.x; i++)
        state.motion.u.set(std::size_t(node_slot(block.model.anatomy.lattice, i, j, 0)),
                           {0, 0, side ? kShift : -kShift});
    energies[side] = lattice::energy(Exec(2), block.model, state);
  }
  return (energies[1] - energies[0]) / (2 * double(kShift));
}

}  // namespace turgor::contact
