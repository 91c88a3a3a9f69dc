// Copies of the nodes beside a blade: one for every part of the tissue around a node but the one that it lies
// in. Pieces of neighbouring cells are one part where they share area in a face.
#pragma once

#include "turgor/models/lattice/cutting/fragments.hpp"

namespace turgor::lattice {

/// Makes Pieces::copies, but for their sources, and gives the pieces of all cells around cut ones their
/// corners.
void make_copies(Fragments& pieces);

}  // namespace turgor::lattice
