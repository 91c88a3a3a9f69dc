#pragma once

#include "turgor/models/lattice/model/model.hpp"

namespace turgor::lattice {

/// Mass of all nodes that nothing fixes [kg].
double moving_mass(const Anatomy& anatomy);

}  // namespace turgor::lattice
