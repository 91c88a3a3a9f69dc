// Nearest point of a triangle.
#pragma once

#include <algorithm>
#include <limits>

#include "turgor/core/vec.hpp"

namespace turgor {

struct TrianglePoint {
  int triangle = -1;
  Vec3d weights;        // barycentric
  Vec3d position;       // [m]
  double distance = 0;  // from the query point [m]
};

/// Parameter of p's projection onto the line ab, clamped to the edge: 0 at a, 1 at b.
TURGOR_HD inline double foot_on_edge(Vec3d p, Vec3d a, Vec3d b) {
  const double length2 = dot(b - a, b - a);
  return length2 > 0 ? std::clamp(dot(p - a, b - a) / length2, 0.0, 1.0) : 0;
}

/// Barycentric weights of p's projection onto the plane of abc.
TURGOR_HD inline Vec3d foot_on_plane(Vec3d p, Vec3d a, Vec3d b, Vec3d c) {
  const Vec3d n = cross(b - a, c - a);
  const double area2 = dot(n, n);
  if (!(area2 > 0)) return {-1, -1, -1};
  const double v = dot(cross(p - a, c - a), n) / area2, w = dot(cross(b - a, p - a), n) / area2;
  return {1 - v - w, v, w};
}

/// Nearest point of the triangle abc; also for degenerate triangles.
TURGOR_HD inline TrianglePoint nearest_on_triangle(Vec3d p, Vec3d a, Vec3d b, Vec3d c) {
  const Vec3d weights = foot_on_plane(p, a, b, c);
  if (weights.x > 0 && weights.y > 0 && weights.z > 0) {
    const Vec3d position = a * weights.x + b * weights.y + c * weights.z;
    return {-1, weights, position, norm(p - position)};
  }
  const Vec3d x[3] = {a, b, c};
  TrianglePoint nearest;
  nearest.distance = std::numeric_limits<double>::infinity();
  for (int side = 0; side < 3; side++) {
    const int from = side, to = (side + 1) % 3;
    const double t = foot_on_edge(p, x[from], x[to]);
    const Vec3d position = x[from] * (1 - t) + x[to] * t;
    if (const double d = norm(p - position); d < nearest.distance) {
      nearest = {-1, {}, position, d};
      nearest.weights[from] = 1 - t;
      nearest.weights[to] = t;
    }
  }
  return nearest;
}

/// Nearest point of a triangle to a point, as weights of its corners (each ≥ 0, with sum 1).
// Voronoi regions of the triangle's features, distinguished by signs of dot products. [Ericson, Real-Time
// Collision Detection 5.1.5]
TURGOR_HD inline Vec3d closest_weights(Vec3d x, Vec3d a, Vec3d b, Vec3d c) {
  const Vec3d ab = b - a, ac = c - a;
  const double d1 = dot(ab, x - a), d2 = dot(ac, x - a);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const double d3 = dot(ab, x - b), d4 = dot(ac, x - b);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double d5 = dot(ab, x - c), d6 = dot(ac, x - c);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double on_c = d1 * d4 - d3 * d2;
  if (on_c <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  const double on_b = d5 * d2 - d1 * d6;
  if (on_b <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  const double on_a = d3 * d6 - d5 * d4;
  if (on_a <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - t, t};
  }
  const double sum = on_a + on_b + on_c;
  return {1 - on_b / sum - on_c / sum, on_b / sum, on_c / sum};
}

}  // namespace turgor
