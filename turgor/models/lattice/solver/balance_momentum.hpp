// Momentum of a body that nothing fixes. The sweeps of a step end before they have converged. The forces
// inside the body sum to zero in every state, but the inertial and external forces do not: the body would
// take another impulse than the reported forces of its contacts, which the other bodies bear.
#pragma once

#include "turgor/models/lattice/model/inputs.hpp"

namespace turgor::lattice {

/// After the sweeps, shifts a body that nothing fixes. Its momentum then changes by the impulses of gravity,
/// loads and the reported forces of contacts and springs. Does nothing while a row sleeps. The rotation stays
/// as the sweeps leave it.
void balance_momentum(const Model& model, State& state, const Inputs& inputs, double dt);

}  // namespace turgor::lattice
