#include "turgor/geometry/triangle_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace turgor {

TriangleTree build_triangle_tree(std::vector<Vec3d> vertices, std::vector<Int3> triangles) {
  std::vector<Box> boxes;
  boxes.reserve(triangles.size());
  for (const auto [a, b, c] : triangles) {
    const std::array<Vec3d, 3> x{vertices[std::size_t(a)], vertices[std::size_t(b)],
                                 vertices[std::size_t(c)]};
    boxes.push_back(box_around(x));
  }
  return {std::move(vertices), std::move(triangles), build_box_tree(boxes)};
}

TrianglePoint nearest_point(const TriangleTree& tree, Vec3d p) {
  TrianglePoint nearest;
  nearest_item(tree.boxes, p, std::numeric_limits<double>::infinity(), [&](int item, double best) {
    const auto [a, b, c] = tree.triangles[std::size_t(item)];
    const auto& x = tree.vertices;
    TrianglePoint at = nearest_on_triangle(p, x[std::size_t(a)], x[std::size_t(b)], x[std::size_t(c)]);
    const double squared = at.distance * at.distance;
    if (squared < best) nearest = at, nearest.triangle = item;
    return squared;
  });
  return nearest;
}

}  // namespace turgor
