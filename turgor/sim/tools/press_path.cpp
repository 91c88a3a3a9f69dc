#include "turgor/sim/tools/press_path.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor {

namespace {

constexpr double kFar = std::numeric_limits<double>::max();
constexpr double kClearance = 0.002;  // height of the tip above the surface before and after a grasp [m]
constexpr int kSlideRows = 32;

struct Corners {
  Vec3d a, b, c;
};
Corners corners(const RestSurface& surface, Int3 t) {
  return {surface.vertices[std::size_t(t.x)], surface.vertices[std::size_t(t.y)],
          surface.vertices[std::size_t(t.z)]};
}

/// Distance along a ray to a triangle (Möller and Trumbore 1997); empty if it misses.
std::optional<double> ray_distance(const Corners& t, Vec3d from, Vec3d direction) {
  const Vec3d ab = t.b - t.a, ac = t.c - t.a, p = cross(direction, ac);
  const double det = dot(ab, p);
  if (det == 0) return std::nullopt;
  const Vec3d s = from - t.a, q = cross(s, ab);
  const double u = dot(s, p) / det, v = dot(direction, q) / det, distance = dot(ac, q) / det;
  if (u < 0 || v < 0 || u + v > 1 || distance < 0) return std::nullopt;
  return distance;
}

/// Nearest point of a triangle: inside, else on an edge.
Vec3d nearest_point(const Corners& t, Vec3d p) {
  const Vec3d ab = t.b - t.a, ac = t.c - t.a, n = cross(ab, ac);
  const double nn = dot(n, n);
  if (nn > 0) {
    const double v = dot(cross(p - t.a, ac), n) / nn, w = dot(cross(ab, p - t.a), n) / nn;
    if (v >= 0 && w >= 0 && v + w <= 1) return t.a + ab * v + ac * w;
  }
  const auto on_edge = [&](Vec3d a, Vec3d b) {
    const double length = dot(b - a, b - a);
    return a + (b - a) * (length > 0 ? std::clamp(dot(p - a, b - a) / length, 0.0, 1.0) : 0.0);
  };
  Vec3d best = on_edge(t.a, t.b);
  for (const Vec3d other : {on_edge(t.b, t.c), on_edge(t.c, t.a)})
    if (norm(other - p) < norm(best - p)) best = other;
  return best;
}

Vec3d nearest_point(const RestSurface& surface, Vec3d p) {
  Vec3d best = p;
  double distance = kFar;
  for (const Int3 t : surface.triangles) {
    const Vec3d point = nearest_point(corners(surface, t), p);
    if (const double d = norm(point - p); d < distance) distance = d, best = point;
  }
  return best;
}

std::optional<Vec3d> first_hit(const RestSurface& surface, Vec3d from, Vec3d direction) {
  double nearest = kFar;
  for (const Int3 t : surface.triangles)
    if (const auto d = ray_distance(corners(surface, t), from, direction)) nearest = std::min(nearest, *d);
  if (nearest == kFar) return std::nullopt;
  return from + direction * nearest;
}

/// Mean normal of the triangles within `reach` of a point, weighted by 1 − d²/reach²; the normal of the
/// nearest triangle if there are none.
Vec3d normal_around(const RestSurface& surface, Vec3d point, double reach) {
  TURGOR_CHECK(reach > 0, "a mean normal is over an area");
  Vec3d sum, nearest;
  double distance = kFar;
  for (const Int3 triangle : surface.triangles) {
    const Corners t = corners(surface, triangle);
    const Vec3d n = cross(t.b - t.a, t.c - t.a);
    const double d = norm(nearest_point(t, point) - point);
    if (d < distance) distance = d, nearest = n;
    sum += n * std::max(0.0, 1 - d * d / (reach * reach));
  }
  return normalized(norm(sum) > 0 ? sum : nearest);
}

struct SurfaceBox {
  Vec3d low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};
};
SurfaceBox box_of(const RestSurface& surface) {
  SurfaceBox box;
  for (const Int3 t : surface.triangles)
    for (const int corner : {t.x, t.y, t.z}) {
      const Vec3d x = surface.vertices[std::size_t(corner)];
      box = {min(box.low, x), max(box.high, x)};
    }
  return box;
}

/// First surface point along the inward normal of the side that the fractions select; empty without such a
/// side.
std::optional<Vec3d> visible_from_side(const RestSurface& surface, Vec3d point, Vec3d fraction) {
  for (int axis = 0; axis < 3; axis++) {
    if (fraction[axis] != 0 && fraction[axis] != 1) continue;
    Vec3d inwards;
    inwards[axis] = fraction[axis] == 0 ? 1 : -1;
    return first_hit(surface, point, inwards);
  }
  return std::nullopt;
}

PathRow row_above(const SurfaceSample& sample, double time, double height) {
  return {.time = time,
          .position = sample.point + sample.normal * height,
          .hold = false,
          .orientation = turned_to(sample.normal)};
}

}  // namespace

SurfaceSample sample_surface(const RestSurface& surface, Vec3d target, bool by_fraction, double reach) {
  TURGOR_CHECK(!surface.triangles.empty(), "a surface has triangles");
  Vec3d point = target;
  std::optional<Vec3d> visible;
  if (by_fraction) {
    const SurfaceBox box = box_of(surface);
    point = box.low + hadamard(target, box.high - box.low);
    visible = visible_from_side(surface, point, target);
  }
  point = visible ? *visible : nearest_point(surface, point);
  return {point, normal_around(surface, point, reach)};
}

ToolPath press_path(const RestSurface& surface, const Press& press, double tip, double radius) {
  TURGOR_CHECK(radius > 0, "a tool has a width");
  const double reach = 3 * radius, up = tip + press.clearance, down = tip - press.depth;
  const auto sample_at = [&](double s) {
    return sample_surface(surface, press.at * (1 - s) + press.to * s, press.by_fraction, reach);
  };

  // the first press starts above the surface
  const SurfaceSample first = sample_at(0), last = press.slide > 0 ? sample_at(1) : first;
  ToolPath path{.rows = {row_above(first, press.start, up)}, .smooth = true};
  double time = press.start;
  const auto add_press = [&] {
    // approach
    path.rows.push_back(row_above(first, time += press.duration, down));
    if (press.hold > 0) path.rows.push_back(row_above(first, time += press.hold, down));

    // slide
    if (press.slide > 0) {
      for (int n = 1; n <= kSlideRows; n++) {
        const double s = double(n) / kSlideRows;
        path.rows.push_back(row_above(sample_at(s), time + s * press.slide, down));
      }
      time += press.slide;
      if (press.hold > 0) path.rows.push_back(row_above(last, time += press.hold, down));
    }

    // retreat
    path.rows.push_back(row_above(last, time += press.duration, up));
  };
  for (int n = 0; n < press.times; n++) {
    if (n > 0 && press.slide > 0) path.rows.push_back(row_above(first, time += press.duration, up));
    add_press();
  }
  TURGOR_CHECK(is_ascending(path.rows, &PathRow::time), "the times of a path ascend");
  return path;
}

ToolPath grasp_path(const RestSurface& surface, const Grasp& grasp, double tip, double radius) {
  // target and lateral displacement
  const SurfaceSample sample = sample_surface(surface, grasp.at, grasp.by_fraction, 3 * radius);
  const Vec3d aside = grasp.aside - sample.normal * dot(grasp.aside, sample.normal);
  double time = grasp.start;
  ToolPath path{.rows = {row_above(sample, time, tip + kClearance)}, .smooth = true};
  const auto add = [&](double duration, double height, double s, bool hold) {
    PathRow row = row_above(sample, time += duration, tip + height);
    row.position += aside * s, row.hold = hold;
    path.rows.push_back(row);
  };

  // approach, grasp, pull, release
  add(grasp.duration, -grasp.depth, 0, true);
  add(grasp.hold, -grasp.depth, 0, true);
  add(grasp.duration, grasp.pull, 1, true);
  add(grasp.hold, grasp.pull, 1, false);
  add(grasp.hold, grasp.pull, 1, false);
  add(grasp.duration, std::max(grasp.pull, kClearance), 1, false);
  TURGOR_CHECK(is_ascending(path.rows, &PathRow::time), "the times of a path ascend");
  return path;
}

}  // namespace turgor
