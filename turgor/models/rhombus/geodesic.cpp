#include "turgor/models/rhombus/geodesic.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::rhombus {

namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

/// Distance of c through the triangle abc, for distances da and db of a and b from the source.
double through_edge(Vec3d a, Vec3d b, Vec3d c, double da, double db) {
  TURGOR_CHECK(da >= 0 && db >= 0, "a distance is not negative");
  const double along_edges = std::min(da + norm(c - a), db + norm(c - b));
  const double length = norm(b - a);
  const bool is_triangle = std::abs(da - db) < length && da + db > length * (1 - 1e-9);
  if (!is_triangle) return along_edges;
  // In the triangle's plane: a is the origin, b on the first axis, c above it, the source below.
  const Vec3d first = (b - a) / length;
  const double cx = dot(c - a, first), cy = norm(c - a - first * cx);
  const double sx = (length * length + da * da - db * db) / (2 * length);
  const double sy = std::sqrt(std::max(0.0, da * da - sx * sx));
  const double crossing = sx + (cx - sx) * sy / (cy + sy);
  if (crossing < 0 || crossing > length) return along_edges;
  return std::sqrt((cx - sx) * (cx - sx) + (cy + sy) * (cy + sy));
}

/// Heap order: smallest distance first, equal ones by vertex, so that the result is deterministic.
bool later(const std::pair<double, int>& a, const std::pair<double, int>& b) { return a > b; }

/// Updates the distance of a vertex if it is shorter. Gains below rounding are ignored, because they could go
/// on forever. The front passes the radius by the longest edge, so that it reaches every vertex within from
/// all sides.
void relax(GeodesicField& field, double margin, int vertex, double distance) {
  double& known = field.distance[std::size_t(vertex)];
  if (!(distance < known * (1 - 1e-12)) || distance > field.radius + margin) return;
  if (known == kFar) field.reached.push_back(vertex);
  known = distance;
  field.front.emplace_back(distance, vertex);
  std::push_heap(field.front.begin(), field.front.end(), later);
}

/// Propagates from a vertex over one of its triangles: along both sides, and through the opposite edges.
void relax_triangle(const Surface& surface, int corner, GeodesicField& field) {
  const int t = corner / 3, i = corner % 3;
  const auto vertex = [&](int k) { return corner_vertex(surface, t, i + k); };
  const auto x = [&](int k) { return surface.vertices[std::size_t(vertex(k))]; };
  const auto d = [&](int k) { return field.distance[std::size_t(vertex(k))]; };
  for (const int to : {1, 2}) {
    const int other = 3 - to;
    const double distance =
        d(other) < kFar ? through_edge(x(0), x(other), x(to), d(0), d(other)) : d(0) + norm(x(to) - x(0));
    relax(field, surface.longest_edge, vertex(to), distance);
  }
}

}  // namespace

void measure_distances(const Surface& surface, const TrianglePoint& source, double radius,
                       GeodesicField& field) {
  TURGOR_CHECK(is_index(source.triangle, surface.triangles.size()) && radius >= 0,
               "distances begin in a triangle of the surface");
  // clear the last run
  for (const int v : field.reached) field.distance[std::size_t(v)] = kFar;
  field.distance.resize(surface.vertices.size(), kFar);
  field.reached.clear(), field.front.clear();
  field.source = source, field.radius = radius;
  // start at the source's triangle
  for (int corner = 0; corner < 3; corner++)
    relax(field, surface.longest_edge, corner_vertex(surface, source.triangle, corner),
          norm(corner_position(surface, source.triangle, corner) - source.position));
  // propagate
  while (!field.front.empty()) {
    const auto [distance, vertex] = field.front.front();
    std::pop_heap(field.front.begin(), field.front.end(), later);
    field.front.pop_back();
    if (distance > field.distance[std::size_t(vertex)]) continue;  // outdated entry
    for (const int corner : corners_of(surface, vertex)) relax_triangle(surface, corner, field);
  }
  std::sort(field.reached.begin(), field.reached.end());
}

}  // namespace turgor::rhombus
