// Rim nodes of partial cells (build/partial_cells.hpp) after a cut.
#pragma once

#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

/// Removes the rim nodes around which no whole cell is left, since nothing would hold them.
void remove_loose_rim(const Model& model, Cuts& cuts);

}  // namespace turgor::lattice
