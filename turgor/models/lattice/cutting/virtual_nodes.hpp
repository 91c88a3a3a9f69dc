// Creation of virtual nodes next to a blade. Fragments of neighboring cells are connected if they share area
// in a face. Each group of connected fragments around a node gets one virtual node, except the group that
// contains the node. [Molino, Bao and Fedkiw 2004]
#pragma once

#include "turgor/models/lattice/cutting/fragment_stages.hpp"

namespace turgor::lattice {

/// Creates Fragments::virtual_nodes without their fit terms, and sets the corners of the fragments that use
/// them.
void make_virtual_nodes(const EarlierFragments& earlier, Fragments& fragments);

}  // namespace turgor::lattice
