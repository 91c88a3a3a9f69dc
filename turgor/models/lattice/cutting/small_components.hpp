// Agglomeration of small components. Blades that are close to each other can isolate a few fine nodes between
// them, although these belong to the tip of a larger piece of tissue. A component is small if it has fewer
// whole sub-cells than one cell. It is merged into a neighboring component.
#pragma once

#include "turgor/models/lattice/cutting/fragment_stages.hpp"

namespace turgor::lattice {

/// Gives fragments of small components the corners of a larger component in their cell, preferably one on the
/// same side of the blades. Removes virtual nodes that are then unused. Requires make_virtual_nodes.
void merge_small_components(const Cuts& cuts, const EarlierFragments& earlier, Fragments& out);

}  // namespace turgor::lattice
