#include "turgor/geometry/triangle_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace turgor {

namespace {

/// Where p's foot on the line ab is, kept within the edge: 0 at a, 1 at b.
double along_edge(Vec3d p, Vec3d a, Vec3d b) {
  const double length2 = dot(b - a, b - a);
  return length2 > 0 ? std::clamp(dot(p - a, b - a) / length2, 0.0, 1.0) : 0;
}

/// Barycentric weights of p's foot on the plane of abc.
Vec3d plane_weights(Vec3d p, Vec3d a, Vec3d b, Vec3d c) {
  const Vec3d n = cross(b - a, c - a);
  const double area2 = dot(n, n);
  if (!(area2 > 0)) return {-1, -1, -1};
  const double v = dot(cross(p - a, c - a), n) / area2, w = dot(cross(b - a, p - a), n) / area2;
  return {1 - v - w, v, w};
}

}  // namespace

TrianglePoint nearest_on_triangle(Vec3d p, Vec3d a, Vec3d b, Vec3d c) {
  const Vec3d weights = plane_weights(p, a, b, c);
  if (weights.x > 0 && weights.y > 0 && weights.z > 0) {
    const Vec3d place = a * weights.x + b * weights.y + c * weights.z;
    return {-1, weights, place, norm(p - place)};
  }
  const std::array<Vec3d, 3> x{a, b, c};
  TrianglePoint nearest;
  nearest.distance = std::numeric_limits<double>::infinity();
  for (int side = 0; side < 3; side++) {
    const int from = side, to = (side + 1) % 3;
    const double t = along_edge(p, x[std::size_t(from)], x[std::size_t(to)]);
    const Vec3d place = x[std::size_t(from)] * (1 - t) + x[std::size_t(to)] * t;
    if (const double d = norm(p - place); d < nearest.distance) {
      nearest = {-1, {}, place, d};
      nearest.weights[from] = 1 - t;
      nearest.weights[to] = t;
    }
  }
  return nearest;
}

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
