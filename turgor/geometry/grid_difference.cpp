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

std::string axes_differ(const Grid& grid, const Grid& expected) {
  return "axes turned by " + text_of(turned(grid.axes, expected.axes)) + " degrees";
}

/// Largest distance of samples that agree [m], as same_grid has it.
double tolerance(const Grid& grid) {
  return 0.01 * std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z});
}

/// Difference in spacing or axes; empty if they agree. `sizes`: numbers of spacings along the axes.
std::string shape_difference(const Grid& grid, const Grid& expected, Int3 sizes) {
  for (int axis = 0; axis < 3; axis++) {
    const double far = std::abs(grid.spacing[axis] - expected.spacing[axis]) * sizes[axis];
    if (far > tolerance(expected))
      return differs("spacing", grid.spacing * 1e3, expected.spacing * 1e3, " x ", " mm");
  }
  return turned(grid.axes, expected.axes) > 0.01 ? axes_differ(grid, expected) : std::string();
}

std::string sample_text(Int3 at) {
  return "(" + std::to_string(at.x) + ", " + std::to_string(at.y) + ", " + std::to_string(at.z) + ")";
}

}  // namespace

std::string grid_difference(const Grid& grid, const Grid& expected) {
  const auto order = axis_order(grid.axes, expected.axes);
  const Grid g = order ? reordered(grid, *order) : grid;
  if (!(g.size == expected.size)) return differs("size", Vec3d(g.size), Vec3d(expected.size), " x ", "");
  if (const std::string shape = shape_difference(g, expected, expected.size); !shape.empty()) return shape;
  return differs("origin", g.origin * 1e3, expected.origin * 1e3, ", ", " mm");
}

std::string box_difference(const Grid& box, const Grid& whole) {
  // shape
  const auto order = axis_order(box.axes, whole.axes);
  if (!order) return axes_differ(box, whole);
  const Grid g = reordered(box, *order);
  const Int3 steps = g.size - Int3{1, 1, 1};
  if (const std::string shape = shape_difference(g, whole, steps); !shape.empty()) return shape;

  // position
  const Int3 first = first_covered(g, whole), last = first + steps;
  const Vec3d nearest = point_at(whole, Vec3d(first));
  if (norm(g.origin - nearest) > tolerance(whole))
    return "origin " + triple(g.origin * 1e3, ", ") + " mm between samples, the nearest at " +
           triple(nearest * 1e3, ", ") + " mm";
  for (int axis = 0; axis < 3; axis++)
    if (first[axis] < 0 || last[axis] >= whole.size[axis])
      return "origin " + triple(g.origin * 1e3, ", ") + " mm: it reaches from sample " + sample_text(first) +
             " to " + sample_text(last) + ", outside of " + triple(Vec3d(whole.size), " x ") + " samples";
  return axes_differ(g, whole);
}

}  // namespace turgor
