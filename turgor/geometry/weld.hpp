// Welding of coincident vertices, so that triangles share them.
#pragma once

#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// Keeps all vertices. Triangles use the first of coincident vertices; triangles with two coincident corners
/// are dropped.
TriMesh welded(const TriMesh& surface);

}  // namespace turgor
