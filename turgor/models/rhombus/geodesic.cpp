#include "turgor/models/rhombus/geodesic.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace turgor::rhombus {

namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

/// Distance of c through the triangle abc, when a and b are da and db from the source.
double through_edge(Vec3d a, Vec3d b, Vec3d c, double da, double db) {
  const double along_edges = std::min(da + norm(c - a), db + norm(c - b));
  const double length = norm(b - a);
  const bool is_triangle = std::abs(da - db) < length && da + db > length * (1 - 1e-9);
  if (!is_triangle) return along_edges;
  // In the triangle's plane: a is the origin, b lies on the first axis, c above it, the source below.
  const Vec3d first = (b - a) / length;
  const double cx = dot(c - a, first), cy = norm(c - a - first * cx);
  const double sx = (length * length + da * da - db * db) / (2 * length);
  const double sy = std::sqrt(std::max(0.0, da * da - sx * sx));
  const double crossing = sx + (cx - sx) * sy / (cy + sy);
  if (crossing < 0 || crossing > length) return along_edges;
  return std::sqrt((cx - sx) * (cx - sx) + (cy + sy) * (cy + sy));
}

/// The smallest distance first; equal ones by vertex, so that every run goes the same way.
bool later(const std::pair<double, int>& a, const std::pair<double, int>& b) { return a > b; }

/// Takes a shorter distance of a vertex. Gains below rounding are none: they could go on for ever. The front
/// runs past the radius by the longest edge, so that it comes to every vertex within from all sides.
void offer(GeodesicField& field, double margin, int vertex, double distance) {
  double& known = field.distance[std::size_t(vertex)];
  if (!(distance < known * (1 - 1e-12)) || distance > field.radius + margin) return;
  if (known == kFar) field.reached.push_back(vertex);
  known = distance;
  field.front.emplace_back(distance, vertex);
  std::push_heap(field.front.begin(), field.front.end(), later);
}

/// From a vertex over a triangle that has it: along both sides, and through them with the corner beyond.
void advance(const Surface& surface, int corner, GeodesicField& field) {
  const int t = corner / 3, i = corner % 3;
  const auto vertex = [&](int k) { return corner_vertex(surface, t, i + k); };
  const auto x = [&](int k) { return surface.vertices[std::size_t(vertex(k))]; };
  const auto d = [&](int k) { return field.distance[std::size_t(vertex(k))]; };
  for (const int to : {1, 2}) {
    const int other = 3 - to;
    const double distance =
        d(other) < kFar ? through_edge(x(0), x(other), x(to), d(0), d(other)) : d(0) + norm(x(to) - x(0));
    offer(field, surface.longest_edge, vertex(to), distance);
  }
}

}  // namespace

void measure_distances(const Surface& surface, const TrianglePoint& source, double radius,
                       GeodesicField& field) {
  for (const int v : field.reached) field.distance[std::size_t(v)] = kFar;
  field.distance.resize(surface.vertices.size(), kFar);
  field.reached.clear(), field.front.clear();
  field.source = source, field.radius = radius;
  for (int corner = 0; corner < 3; corner++)
    offer(field, surface.longest_edge, corner_vertex(surface, source.triangle, corner),
          norm(corner_place(surface, source.triangle, corner) - source.place));
  while (!field.front.empty()) {
    const auto [distance, vertex] = field.front.front();
    std::pop_heap(field.front.begin(), field.front.end(), later);
    field.front.pop_back();
    if (distance > field.distance[std::size_t(vertex)]) continue;  // a shorter one came since
    for (const int corner : corners_of(surface, vertex)) advance(surface, corner, field);
  }
  std::sort(field.reached.begin(), field.reached.end());
}

}  // namespace turgor::rhombus
