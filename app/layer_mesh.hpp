// A round layer of tetrahedra whose nodes lie on circles, so that a round indenter's edge is where nodes are.
#pragma once

#include <span>

#include "turgor/geometry/solid_mesh.hpp"

namespace turgor {

/// Circles of these radii, ascending, around a node in the middle, and planes of these heights, ascending
/// [m]. Circle number i has 6 i nodes.
SolidMesh round_layer(std::span<const double> radii, std::span<const double> heights);

}  // namespace turgor
