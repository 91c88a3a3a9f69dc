// A surface of a few triangles made round, for pictures of a part of a body that is a handful of elements:
// its corners are the mesh's and no shape that anybody gave.
#pragma once

#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// The ellipsoid with the volume, the centre and, in proportion, the second moments of what a closed surface
/// encloses. Without normals and scalars. What encloses nothing stays as it is.
TriMesh rounded(const TriMesh& coarse);

}  // namespace turgor
