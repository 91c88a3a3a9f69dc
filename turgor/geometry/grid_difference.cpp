#include "turgor/geometry/grid_difference.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "turgor/geometry/reorient.hpp"

namespace turgor {

namespace {

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.7g", value);
  return text;
}

std::string triple(Vec3d v, const char* between) {
  return text_of(v.x) + between + text_of(v.y) + between + text_of(v.z);
}

std::string differs(const char* what, Vec3d found, Vec3d expected, const char* between, const char* unit) {
  return std::string(what) + " " + triple(found, between) + unit + ", not " + triple(expected, between) +
         unit;
}

/// Largest angle between an axis and its expected direction [degrees].
double turned(const Mat3d& a, const Mat3d& b) {
  double largest = 0;
  for (int axis = 0; axis < 3; axis++)
    largest = std::max(largest, std::acos(std::clamp(dot(a.column[axis], b.column[axis]), -1.0, 1.0)));
  return largest * 180 / M_PI;
}

}  // namespace

std::string grid_difference(const Grid& grid, const Grid& expected) {
  const auto order = axis_order(grid.axes, expected.axes);
  const Grid g = order ? reordered(grid, *order) : grid;
  if (!(g.size == expected.size)) return differs("size", Vec3d(g.size), Vec3d(expected.size), " x ", "");
  for (int axis = 0; axis < 3; axis++) {
    const double far = std::abs(g.spacing[axis] - expected.spacing[axis]) * expected.size[axis];
    if (far > 0.01 * expected.spacing[axis])
      return differs("spacing", g.spacing * 1e3, expected.spacing * 1e3, " x ", " mm");
  }
  if (!order || turned(g.axes, expected.axes) > 0.01)
    return "axes turned by " + text_of(turned(g.axes, expected.axes)) + " degrees";
  return differs("origin", g.origin * 1e3, expected.origin * 1e3, ", ", " mm");
}

}  // namespace turgor
