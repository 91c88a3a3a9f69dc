// Axis-aligned boxes: bounds of points, unions, overlaps and distances.
#pragma once

#include <span>

#include "turgor/core/vec.hpp"

namespace turgor {

struct Box {
  Vec3d low, high;  // [m]
};

/// Smallest box around some points, at least one.
inline Box box_around(std::span<const Vec3d> points) {
  Box box{points[0], points[0]};
  for (const Vec3d p : points) box = {min(box.low, p), max(box.high, p)};
  return box;
}
/// Smallest box around both.
inline Box joined(const Box& a, const Box& b) { return {min(a.low, b.low), max(a.high, b.high)}; }
inline bool meet(const Box& a, const Box& b) {
  return a.low.x <= b.high.x && a.low.y <= b.high.y && a.low.z <= b.high.z && b.low.x <= a.high.x &&
         b.low.y <= a.high.y && b.low.z <= a.high.z;
}
/// Squared distance from a point to a box; 0 inside [m²].
TURGOR_HD inline double squared_distance(const Box& box, Vec3d p) {
  const Vec3d d = p - min(max(p, box.low), box.high);
  return dot(d, d);
}

}  // namespace turgor
