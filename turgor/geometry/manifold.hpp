// A mesh whose surface is a closed manifold: every edge of it has two triangles, every vertex one ring of
// them. Also the choice of some elements of a mesh.
#pragma once

#include <cstdint>
#include <span>

#include "turgor/geometry/solid_mesh.hpp"

namespace turgor {

/// The elements whose flag is not 0 and the vertices they use, in their order.
SolidMesh kept_elements(const SolidMesh& mesh, std::span<const std::uint8_t> keep);

/// Parts of a tetrahedral mesh that meet in a single vertex are given one each, at the same place; where they
/// meet in an edge, or two openings in a vertex, the elements there are removed but for the largest
/// group. Regions are kept.
SolidMesh made_manifold(SolidMesh mesh);

}  // namespace turgor
