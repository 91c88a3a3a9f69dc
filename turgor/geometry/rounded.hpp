// Ellipsoid in the shape of a coarse surface, for pictures of regions with only a few elements.
#pragma once

#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// Ellipsoid with the volume, the center and, up to scale, the second moments of a closed surface. Without
/// normals and scalars. A surface without volume is returned unchanged.
TriMesh rounded(const TriMesh& coarse);

}  // namespace turgor
