// Momentum of a body that nothing fixes. The sweeps of a step end before they have converged. The forces
// inside the body sum to zero in every state, but the inertial and external forces do not: the body would
// take another impulse than the reported forces of its contacts, which the other bodies bear.
#pragma once

#include "turgor/models/lattice/model/inputs.hpp"

namespace turgor::lattice {

/// Residual of the translation after the sweeps, R = Σ m (y − u)/h² + Σ f over the nodes and contacts of a
/// body that nothing fixes: what the forces of its contacts exceed those that its momentum shows, lattice
/// frame [N]. Zero while a row sleeps, with springs, and while a contact holds a node.
Vec3d unbalanced_force(const Model& model, const State& state, const Inputs& inputs, double dt);

/// After the sweeps, shifts and turns a body that nothing fixes. Its momentum and its angular momentum then
/// change by the impulses of gravity, loads and the reported forces of contacts. Does nothing while a row
/// sleeps, with springs, and while a contact holds a node. A cut body is not turned.
void balance_momentum(const Model& model, State& state, const Inputs& inputs, double dt);

}  // namespace turgor::lattice
