// A triangle surface one can ask for its nearest point.
#pragma once

#include <span>
#include <vector>

#include "turgor/geometry/box_tree.hpp"

namespace turgor {

/// A point of a triangle. A weight that is exactly 0 puts it on the opposite edge, two of them on a corner.
struct TrianglePoint {
  int triangle = -1;
  Vec3d weights;        // barycentric
  Vec3d place;          // [m]
  double distance = 0;  // from the point that was asked for [m]
};

/// The nearest point of the triangle abc; also for triangles without area.
TrianglePoint nearest_on_triangle(Vec3d p, Vec3d a, Vec3d b, Vec3d c);

struct TriangleTree {
  std::vector<Vec3d> vertices;  // [m]
  std::vector<Int3> triangles;
  BoxTree boxes;  // of the triangles
};

TriangleTree build_triangle_tree(std::vector<Vec3d> vertices, std::vector<Int3> triangles);
/// There is at least one triangle.
TrianglePoint nearest_point(const TriangleTree& tree, Vec3d p);

}  // namespace turgor
