// Strain limit for springs: after a step, springs longer than the limit lose the velocity that lengthens
// them.
#pragma once

#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

/// Changes velocities in Jacobi passes over all springs; each vertex takes the mean correction of its
/// springs.
void limit_strain(const Exec& exec, const Model& model, State& state, double dt);

}  // namespace turgor::cloth
