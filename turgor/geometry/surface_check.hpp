// Checks that a triangle surface bounds a body: closed, manifold, consistently oriented. Coincident vertices
// are merged. Inverted orientation, separate components and crossing triangles are tolerated and noted.
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

/// Error: no triangles, coordinates that are not numbers, open edges, edges with more than two triangles,
/// opposite orientations of neighbors, no volume. The message has counts and the first few edges by vertex
/// (counted from 0 in the order of `surface`) and position.
Result<CheckedSurface> check_surface(const Exec& exec, const TriMesh& surface);

/// Sentences about triangles that cross each other, and about components inside others that are no cavities.
/// Empty for a surface that separates inside from outside once. Edges must have two triangles each.
std::vector<std::string> overlap_notes(const Exec& exec, const TriMesh& surface);

/// Pairs of triangles (lower number first, ascending) where an edge of one passes through the other.
/// Neighbors that share an edge are skipped.
std::vector<std::pair<int, int>> crossing_triangles(const Exec& exec, const TriMesh& surface);

}  // namespace turgor
