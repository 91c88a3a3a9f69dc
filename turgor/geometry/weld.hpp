// Welding of coincident vertices, so that triangles share them.
#pragma once

#include <vector>

#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// First vertex with the same coordinates, for every vertex.
template <class T>
std::vector<int> first_coincident(const std::vector<Vec<T>>& vertices);

/// Keeps all vertices. Triangles use the first of coincident vertices; triangles with two coincident corners
/// are dropped.
TriMesh welded(const TriMesh& surface);

}  // namespace turgor
