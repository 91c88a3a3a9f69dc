// Whether a triangle surface bounds a body: closed, manifold, all triangles the same way round. Vertices at
// one place are taken for one; what can be lived with (inside out, loose parts, triangles that cross) is, and
// said.
#pragma once

#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

struct CheckedSurface {
  TriMesh mesh;                    // one body with its cavities; normals point outwards
  double volume = 0;               // [m³]
  std::size_t crossings = 0;       // pairs of triangles
  std::vector<std::string> notes;  // sentences
};

/// Error: no triangles, places that are no numbers, open edges, edges of more than two triangles, neighbours
/// in opposite order, no volume: with counts, and the first few edges by their vertices (counted from 0 in
/// the order of `surface`) and places.
Result<CheckedSurface> check_surface(const Exec& exec, const TriMesh& surface);

/// Pairs of triangles (lower number first, ascending) of which an edge of one passes through the other.
/// Neighbours that share an edge are not looked at.
std::vector<std::pair<int, int>> crossing_triangles(const Exec& exec, const TriMesh& surface);

}  // namespace turgor
