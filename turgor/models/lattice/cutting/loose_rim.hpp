// Rim nodes of partial cells (build/partial_cells.hpp) after a cut.
#pragma once

#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

/// Removes the rim nodes that are left without a whole cell and a cut element, since nothing would hold them.
void remove_loose_rim(const Model& model, State& state);

}  // namespace turgor::lattice
