// Step length of a node between cells that stiffen. A Newton step from a soft state may end where the
// exponential law is stiff beyond measure, so a long step is halved until the energy does not rise.
#pragma once

#include "turgor/models/lattice/mechanics/law_cells.hpp"

namespace turgor::lattice {

/// Steps longer than this share of the least spacing are checked. Shorter ones change the exponents of the
/// laws little: by 0.25 at b = 20 and a strain of 0.3.
constexpr Real kCheckedStep = Real(0.02);

/// Newton step of a node: system of all its elements, with those of its cells.
struct LawNodeStep {
  NodeSystem system;
  Vec3 to_inertial;  // y − x [m]
  Real mobility;     // h² w [s²/kg]
  Vec3 change;       // Newton step [m]
};
/// Share of the Newton step to take, 1, ½, …, 1/64: the first that does not raise the energy of the cells,
/// exactly, and of inertia and all else, by their second order.
Real law_step_share(const Model& model, const State& state, const CellLawView& laws, int slot,
                    const LawNodeStep& step);

}  // namespace turgor::lattice
