// Triangle surface with a bounding volume hierarchy for nearest-point queries.
#pragma once

#include <span>
#include <vector>

#include "turgor/geometry/box_tree.hpp"
#include "turgor/geometry/triangle_point.hpp"

namespace turgor {

/// Vertices, triangles and tree.
struct TriangleTree {
  std::vector<Vec3d> vertices;  // [m]
  std::vector<Int3> triangles;
  BoxTree boxes;  // of the triangles
};

TriangleTree build_triangle_tree(std::vector<Vec3d> vertices, std::vector<Int3> triangles);
/// Nearest point of the surface, which has at least one triangle. A weight of exactly 0 means a point on the
/// opposite edge, two of them a corner.
TrianglePoint nearest_point(const TriangleTree& tree, Vec3d p);

}  // namespace turgor
