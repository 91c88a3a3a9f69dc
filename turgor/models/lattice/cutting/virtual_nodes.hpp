// Creation of virtual nodes next to a blade. Fragments of neighboring cells are connected if they share area
// in a face. Each group of connected fragments around a node gets one virtual node, except the group that
// contains the node. Where a blade ends, fragments on one side of it are connected to a cell that contains
// nodes of the other side. With cut-cell elements they get virtual nodes there too, so both sides separate up
// to the same distance behind the end, whatever the direction of the blade; bridges hold them together
// (fragment_shares.cpp). [Molino, Bao and Fedkiw 2004]
#pragma once

#include "turgor/models/lattice/cutting/fragment_stages.hpp"

namespace turgor::lattice {

/// Creates Fragments::virtual_nodes without their fit terms, and sets the corners of the fragments that use
/// them.
void make_virtual_nodes(const Model& model, const EarlierFragments& earlier, Fragments& fragments);

}  // namespace turgor::lattice
