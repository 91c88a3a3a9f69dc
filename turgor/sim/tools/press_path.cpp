#include "turgor/sim/tools/press_path.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace turgor {

namespace {

constexpr double kFar = std::numeric_limits<double>::max();
constexpr double kClearance = 0.002;  // of the tip above the surface, before and after a press [m]
constexpr int kSlideRows = 32;

struct Corners {
  Vec3d a, b, c;
};
Corners corners(const RestSurface& surface, Int3 t) {
  return {surface.vertices[std::size_t(t.x)], surface.vertices[std::size_t(t.y)],
          surface.vertices[std::size_t(t.z)]};
}

/// Distance along a ray to a triangle (Möller and Trumbore 1997); none when it misses.
std::optional<double> ray_distance(const Corners& t, Vec3d from, Vec3d direction) {
  const Vec3d ab = t.b - t.a, ac = t.c - t.a, p = cross(direction, ac);
  const double det = dot(ab, p);
  if (det == 0) return std::nullopt;
  const Vec3d s = from - t.a, q = cross(s, ab);
  const double u = dot(s, p) / det, v = dot(direction, q) / det, distance = dot(ac, q) / det;
  if (u < 0 || v < 0 || u + v > 1 || distance < 0) return std::nullopt;
  return distance;
}

/// The nearest point of a triangle: inside, else on the nearest edge.
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

/// The mean normal of the triangles around a point, the nearer ones more; that of the nearest when the reach
/// holds none.
Vec3d normal_around(const RestSurface& surface, Vec3d point, double reach) {
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

/// Seen from the side of the box on which the fractions lie; none when they lie inside, or see nothing.
std::optional<Vec3d> seen_from_side(const RestSurface& surface, Vec3d point, Vec3d fraction) {
  for (int axis = 0; axis < 3; axis++) {
    if (fraction[axis] != 0 && fraction[axis] != 1) continue;
    Vec3d inwards;
    inwards[axis] = fraction[axis] == 0 ? 1 : -1;
    return first_hit(surface, point, inwards);
  }
  return std::nullopt;
}

PathRow row_above(const SurfaceSample& place, double time, double height) {
  return {.time = time,
          .position = place.point + place.normal * height,
          .hold = false,
          .orientation = turned_to(place.normal)};
}

}  // namespace

SurfaceSample place_on_surface(const RestSurface& surface, Vec3d place, bool by_fraction, double reach) {
  Vec3d point = place;
  std::optional<Vec3d> seen;
  if (by_fraction) {
    const SurfaceBox box = box_of(surface);
    point = box.low + hadamard(place, box.high - box.low);
    seen = seen_from_side(surface, point, place);
  }
  point = seen ? *seen : nearest_point(surface, point);
  return {point, normal_around(surface, point, reach)};
}

ToolPath press_path(const RestSurface& surface, const Press& press, double tip, double radius) {
  const double reach = 3 * radius, up = tip + kClearance, down = tip - press.depth;
  const auto place = [&](double s) {
    return place_on_surface(surface, press.at * (1 - s) + press.to * s, press.by_fraction, reach);
  };
  const SurfaceSample first = place(0), last = press.slide > 0 ? place(1) : first;
  ToolPath path{.rows = {row_above(first, press.start, up)}, .smooth = true};
  double time = press.start + press.duration;
  path.rows.push_back(row_above(first, time, down));
  if (press.hold > 0) path.rows.push_back(row_above(first, time += press.hold, down));
  if (press.slide > 0) {
    for (int n = 1; n <= kSlideRows; n++) {
      const double s = double(n) / kSlideRows;
      path.rows.push_back(row_above(place(s), time + s * press.slide, down));
    }
    time += press.slide;
    if (press.hold > 0) path.rows.push_back(row_above(last, time += press.hold, down));
  }
  path.rows.push_back(row_above(last, time + press.duration, up));
  return path;
}

ToolPath grasp_path(const RestSurface& surface, const Grasp& grasp, double tip, double radius) {
  const SurfaceSample place = place_on_surface(surface, grasp.at, grasp.by_fraction, 3 * radius);
  const Vec3d aside = grasp.aside - place.normal * dot(grasp.aside, place.normal);
  double time = grasp.start;
  ToolPath path{.rows = {row_above(place, time, tip + kClearance)}, .smooth = true};
  const auto add = [&](double duration, double height, double part, bool hold) {
    PathRow row = row_above(place, time += duration, tip + height);
    row.position += aside * part, row.hold = hold;
    path.rows.push_back(row);
  };
  add(grasp.duration, -grasp.depth, 0, true);
  add(grasp.hold, -grasp.depth, 0, true);
  add(grasp.duration, grasp.pull, 1, true);
  add(grasp.hold, grasp.pull, 1, false);
  add(grasp.hold, grasp.pull, 1, false);
  add(grasp.duration, std::max(grasp.pull, kClearance), 1, false);
  return path;
}

}  // namespace turgor
