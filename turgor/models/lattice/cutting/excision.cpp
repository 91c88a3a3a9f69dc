// Outline, sheet and size of an excision.
#include "turgor/models/lattice/cutting/excision.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/cutting/drawn_curve.hpp"
#include "turgor/models/lattice/cutting/skin_near.hpp"

namespace turgor::lattice {

namespace {

/// Points of an arc of a circle from (−l/2, 0) to (l/2, 0) that reaches (0, −w/2), with equal steps.
std::vector<std::pair<double, double>> arc_points(double length, double width, double step) {
  const double radius = (length * length + width * width) / (4 * width),
               most = std::asin(std::min(1.0, length / (2 * radius)));
  const int count = std::max(4, int(std::ceil(2 * most * radius / step)));
  std::vector<std::pair<double, double>> points;
  for (int n = 0; n <= count; n++) {
    const double angle = most * (2.0 * n / count - 1);
    points.emplace_back(radius * std::sin(angle), radius - width / 2 - radius * std::cos(angle));
  }
  points.front().second = points.back().second = 0;
  return points;
}

}  // namespace

Result<std::vector<Vec3d>> excision_outline(const Model& model, const State& state,
                                            const Excision& excision) {
  TURGOR_ASSERT(excision.length >= excision.width && excision.width > 0, "an outline is longer than wide");
  const Mat3d to_lattice = inverse(model.anatomy.grid.axes);
  const Vec3d center = to_lattice * (excision.center - model.anatomy.grid.origin);
  // frame on the skin
  const SkinNow near = skin_near(model, state.motion, {center}, nullptr);
  if (near.empty()) return Error{off_skin(model, state.motion, "", center)};
  const Vec3d inward = direction_into(near, center, {}, std::max(excision.length / 2, 1e-3));
  const Vec3d drawn = to_lattice * excision.direction;
  const Vec3d flat = drawn - inward * dot(drawn, inward);
  if (!(norm(flat) > 1e-3 * norm(drawn)))
    return Error{"the direction is normal to the skin: expected one along the skin"};
  const double angle = excision.angle * std::numbers::pi / 180;
  const Vec3d first = normalized(flat), second = cross(first, inward),  // counter-clockwise from outside
      along = first * std::cos(angle) + second * std::sin(angle), across = cross(along, inward);
  // two arcs, counter-clockwise seen from outside
  const auto arc =
      arc_points(excision.length, excision.width, 0.499 * smallest_spacing(model.anatomy.lattice));
  std::vector<Vec3d> outline;
  for (const double side : {1.0, -1.0})
    for (const auto& [x, y] : arc) {
      const Vec3d point = center + along * (side * x) + across * (side * y);
      if (outline.empty() || side > 0 || &x != &arc.front().first)
        outline.push_back(model.anatomy.grid.origin + model.anatomy.grid.axes * point);
    }
  outline.back() = outline.front();
  return outline;
}

bool outlines_overlap(std::span<const Vec3d> a, std::span<const Vec3d> b) {
  const auto center_of = [](std::span<const Vec3d> outline) {
    return (outline.front() + outline[outline.size() / 2]) / 2;
  };
  const auto length_of = [](std::span<const Vec3d> outline) {
    return norm(outline.front() - outline[outline.size() / 2]);
  };
  if (norm(center_of(a) - center_of(b)) > (length_of(a) + length_of(b)) / 2) return false;
  // true if a point of one outline lies on the inner side of all edges of the other, which is convex
  const auto enters = [&](std::span<const Vec3d> inner, std::span<const Vec3d> outer) {
    const Vec3d center = center_of(outer);
    Vec3d normal;
    for (std::size_t n = 1; n < outer.size(); n++) normal += cross(outer[n - 1] - center, outer[n] - center);
    return std::any_of(inner.begin(), inner.end(), [&](Vec3d p) {
      for (std::size_t n = 1; n < outer.size(); n++)
        if (dot(cross(outer[n] - outer[n - 1], p - outer[n - 1]), normal) < 0) return false;
      return true;
    });
  };
  return enters(a, b) || enters(b, a);
}

BladeSheet excision_sheet(const BladePath& path, Vec3d middle, double margin, double epsilon) {
  constexpr int kRings = 6;
  const std::size_t count = path.points.size() - 1;  // the last point is the first
  TURGOR_CHECK(count >= 3 && norm(path.points.front() - path.points.back()) < 1e-9, "an outline is closed");
  const Vec3d shift{0.37 * epsilon, 0.61 * epsilon, 0.71 * epsilon};
  const auto at = [&](std::size_t n, double depth) {
    return path.points[n % count] + path.inward[n % count] * depth + shift;
  };
  // walls, above and below the skin
  BladeSheet sheet;
  double along = 0;
  for (std::size_t n = 1; n <= count; n++) {
    const double next = along + norm(path.points[n] - path.points[n - 1]);
    for (const bool above : {true, false}) {
      const auto edge = [&](std::size_t m, bool top) {
        return at(m, top == above ? (top ? -margin : path.depths[m % count]) : 0);
      };
      const Vec3d a = edge(n - 1, true), b = edge(n - 1, false), c = edge(n, true), d = edge(n, false);
      add_triangle(sheet, {a, b, c}, {along, along, next});
      add_triangle(sheet, {c, b, d}, {next, along, next});
    }
    along = next;
  }
  // floor: rings between its center and the walls, at the same depth below a skin that is curved evenly
  const Vec3d inward = mean_inward(path), bottom = middle + shift;
  const auto floor_at = [&](std::size_t n, int ring) {
    const double t = double(ring) / kRings;
    const Vec3d rim = at(n, path.depths[n % count]) - bottom;
    const double height = dot(rim, inward);
    return bottom + (rim - inward * height) * t + inward * (height * t * t);
  };
  for (std::size_t n = 1; n <= count; n++)
    for (int ring = 0; ring < kRings; ring++) {
      const Vec3d a = floor_at(n - 1, ring), b = floor_at(n, ring), c = floor_at(n - 1, ring + 1),
                  d = floor_at(n, ring + 1);
      add_triangle(sheet, {a, d, c}, {along, along, along});
      add_triangle(sheet, {a, b, d}, {along, along, along});
    }
  return sheet;
}

}  // namespace turgor::lattice
