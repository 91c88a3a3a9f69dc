// Vertices that lie at one place made one, so that triangles know their neighbours.
#pragma once

#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// All vertices as they were; triangles take the first vertex of each place, and those with two corners at
/// one place are left out.
TriMesh welded(const TriMesh& surface);

}  // namespace turgor
