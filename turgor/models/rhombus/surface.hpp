// A closed triangle surface with its adjacency, for search, distances and displacements on an organ's
// surface. Contains no physics.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/result.hpp"
#include "turgor/core/vec.hpp"

namespace turgor::rhombus {

struct Surface {
  std::vector<Vec3d> vertices;             // at rest [m]
  std::vector<Int3> triangles;             // counter-clockwise seen from outside
  std::vector<int> across;                 // neighbor across each side of each triangle: 3 · triangle + side
  std::vector<int> corner_begin;           // vertices + 1, into `corners`
  std::vector<int> corners;                // 3 · triangle + corner, by vertex
  std::vector<Vec3d> normals;              // of vertices, unit, outward
  double mean_edge = 0, longest_edge = 0;  // [m]
};

/// Builds a surface. Error, with the first location: no triangles, invalid vertex indices, vertices that are
/// not finite or belong to no triangle, sides of one triangle or of more than two (an open or non-manifold
/// mesh), neighbors of opposite orientation, triangles without area, inside out.
Result<Surface> build_surface(std::vector<Vec3d> vertices, std::vector<Int3> triangles);

/// Corners of the triangles around a vertex, as 3 · triangle + corner.
inline std::span<const int> corners_of(const Surface& surface, int vertex) {
  TURGOR_CHECK(is_index(vertex, surface.vertices.size()), "the vertex belongs to the surface");
  const auto v = std::size_t(vertex);
  const int begin = surface.corner_begin[v], end = surface.corner_begin[v + 1];
  return {surface.corners.data() + begin, std::size_t(end - begin)};
}
inline int corner_vertex(const Surface& surface, int triangle, int corner) {
  return surface.triangles[std::size_t(triangle)][corner % 3];
}
inline Vec3d corner_position(const Surface& surface, int triangle, int corner) {
  return surface.vertices[std::size_t(corner_vertex(surface, triangle, corner))];
}

}  // namespace turgor::rhombus
