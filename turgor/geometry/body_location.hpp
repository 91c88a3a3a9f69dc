// Location of a body, for messages about a point outside it.
#pragma once

#include <span>
#include <string>

#include "turgor/core/number_text.hpp"
#include "turgor/geometry/box.hpp"

namespace turgor {

inline std::string position_text(Vec3d p) {
  return "(" + number_text(p.x) + ", " + number_text(p.y) + ", " + number_text(p.z) + ") m";
}

/// "the body is between (…) m and (…) m; its nearest point, (…) m, is 0.12 m away"
inline std::string describe_location(const Box& box, Vec3d nearest, double distance) {
  return "the body is between " + position_text(box.low) + " and " + position_text(box.high) +
         "; its nearest point, " + position_text(nearest) + ", is " + number_text(distance) + " m away";
}
inline std::string describe_location(std::span<const Vec3d> points, Vec3d position) {
  if (points.empty()) return "the body has no points";
  Vec3d nearest = points[0];
  for (const Vec3d p : points)
    if (norm(p - position) < norm(nearest - position)) nearest = p;
  return describe_location(box_around(points), nearest, norm(nearest - position));
}

}  // namespace turgor
