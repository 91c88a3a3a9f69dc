// Where a body is, for the sentence about a place that is off it.
#pragma once

#include <span>
#include <string>

#include "turgor/core/number_text.hpp"
#include "turgor/geometry/box.hpp"

namespace turgor {

inline std::string place_text(Vec3d p) {
  return "(" + number_text(p.x) + ", " + number_text(p.y) + ", " + number_text(p.z) + ") m";
}

/// "the body lies between (…) m and (…) m; its nearest point, (…) m, is 0.12 m away"
inline std::string where_is(const Box& box, Vec3d nearest, double distance) {
  return "the body lies between " + place_text(box.low) + " and " + place_text(box.high) +
         "; its nearest point, " + place_text(nearest) + ", is " + number_text(distance) + " m away";
}
inline std::string where_is(std::span<const Vec3d> points, Vec3d place) {
  if (points.empty()) return "the body has no points";
  Vec3d nearest = points[0];
  for (const Vec3d p : points)
    if (norm(p - place) < norm(nearest - place)) nearest = p;
  return where_is(box_around(points), nearest, norm(nearest - place));
}

}  // namespace turgor
