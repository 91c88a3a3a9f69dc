// Makes the boundary of a tetrahedral mesh a closed manifold: two triangles at every edge, one ring of
// triangles at every vertex. Non-manifold vertices are split; at non-manifold edges the smaller groups of
// elements are removed.
#pragma once

#include <cstdint>
#include <span>

#include "turgor/geometry/solid_mesh.hpp"

namespace turgor {

/// Elements with a nonzero flag and the vertices they use, in their order.
SolidMesh kept_elements(const SolidMesh& mesh, std::span<const std::uint8_t> keep);

/// Splits vertices in which otherwise separate groups of elements meet. At edges where groups meet, and at
/// vertices with several surface rings, all elements except the largest group are removed. Regions are kept.
SolidMesh make_manifold(SolidMesh mesh);

}  // namespace turgor
