// Cloth hardly stretches: springs that would be longer than the limit after a step lose the part of the
// velocities that makes them so.
#pragma once

#include "turgor/models/cloth/model/cloth.hpp"

namespace turgor::cloth {

/// Changes velocities, all springs at once and each vertex by the mean of what its springs ask.
void limit_strain(const Exec& exec, const Model& model, State& state, double dt);

}  // namespace turgor::cloth
