// Forces of cloth on the surface of a lattice with partial cells, as forces on nodes.
#pragma once

#include "turgor/sim/bodies/cloth/cloth_support.hpp"

namespace turgor {

/// Replaces forces on vertices of the surface, of a lattice with partial cells, by forces on the corners c of
/// their cells, w_c f. The surface moves with these weights. Forces on its outermost nodes would do other
/// work than the surface does, and a sheet on it would not come to rest. Does nothing for other bodies.
void move_to_corners(const World& world, ClothSupport& support);

}  // namespace turgor
