// A closed triangle surface with its neighbourhoods: what walks, measures and moves over an organ's skin. It
// knows no physics.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/core/vec.hpp"

namespace turgor::rhombus {

struct Surface {
  std::vector<Vec3d> vertices;    // at rest [m]
  std::vector<Int3> triangles;    // counter-clockwise seen from outside
  std::vector<int> across;        // beyond each side of each triangle: 3 · triangle + side of the neighbour
  std::vector<int> corner_begin;  // vertices + 1, into `corners`
  std::vector<int> corners;       // 3 · triangle + corner, by vertex
  std::vector<Vec3d> normals;     // of vertices, unit, outward
  double mean_edge = 0, longest_edge = 0;  // [m]
};

/// Error, with the first places where it is wrong: no triangles, numbers of vertices that do not exist,
/// places that are no numbers, vertices of no triangle, sides of one triangle or of more than two (an open or
/// non-manifold mesh), neighbours of opposite order, triangles without area, inside out.
Result<Surface> build_surface(std::vector<Vec3d> vertices, std::vector<Int3> triangles);

/// The corners of triangles that meet at a vertex, as 3 · triangle + corner.
inline std::span<const int> corners_of(const Surface& surface, int vertex) {
  const auto v = std::size_t(vertex);
  const int begin = surface.corner_begin[v], end = surface.corner_begin[v + 1];
  return {surface.corners.data() + begin, std::size_t(end - begin)};
}
inline int corner_vertex(const Surface& surface, int triangle, int corner) {
  return surface.triangles[std::size_t(triangle)][corner % 3];
}
inline Vec3d corner_place(const Surface& surface, int triangle, int corner) {
  return surface.vertices[std::size_t(corner_vertex(surface, triangle, corner))];
}

}  // namespace turgor::rhombus
