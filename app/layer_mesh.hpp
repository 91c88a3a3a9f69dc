// A round layer of tetrahedra with nodes on concentric circles, so that the edge of a round indenter
// coincides with nodes.
#pragma once

#include <span>

#include "turgor/geometry/solid_mesh.hpp"

namespace turgor {

/// Circles of these radii, ascending, around a central node, and planes of these heights, ascending [m].
/// Circle i has 6 i nodes.
SolidMesh round_layer(std::span<const double> radii, std::span<const double> heights);

}  // namespace turgor
