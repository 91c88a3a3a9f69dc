// A triangle surface one can ask for its nearest point.
#pragma once

#include <span>
#include <vector>

#include "turgor/geometry/box_tree.hpp"
#include "turgor/geometry/triangle_point.hpp"

namespace turgor {

/// A point of a triangle. A weight that is exactly 0 puts it on the opposite edge, two of them on a corner.
struct TriangleTree {
  std::vector<Vec3d> vertices;  // [m]
  std::vector<Int3> triangles;
  BoxTree boxes;  // of the triangles
};

TriangleTree build_triangle_tree(std::vector<Vec3d> vertices, std::vector<Int3> triangles);
/// There is at least one triangle.
TrianglePoint nearest_point(const TriangleTree& tree, Vec3d p);

}  // namespace turgor
