#include "turgor/models/rhombus/surface.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/geometry/surface_edges.hpp"

namespace turgor::rhombus {

namespace {

Status check_numbers(const Surface& s) {
  if (s.triangles.empty()) return Error{"the surface has no triangles"};
  const int count = int(s.vertices.size());
  for (std::size_t t = 0; t < s.triangles.size(); t++)
    for (int corner = 0; corner < 3; corner++)
      if (const int v = s.triangles[t][corner]; v < 0 || v >= count)
        return Error{"triangle " + std::to_string(t) + ": expected vertices from 0 to " +
                     std::to_string(count - 1) + ", found " + std::to_string(v)};
  for (std::size_t v = 0; v < s.vertices.size(); v++)
    if (!is_finite(s.vertices[v]))
      return Error{"vertex " + std::to_string(v) + ": its position is not finite"};
  return Done{};
}

/// Lists the corners around each vertex.
void gather_corners(Surface& s) {
  s.corner_begin.assign(s.vertices.size() + 1, 0);
  for (const Int3 t : s.triangles)
    for (const int v : {t.x, t.y, t.z}) s.corner_begin[std::size_t(v) + 1]++;
  for (std::size_t v = 0; v < s.vertices.size(); v++) s.corner_begin[v + 1] += s.corner_begin[v];
  TURGOR_CHECK(is_csr(s.corner_begin, 3 * s.triangles.size()), "the vertices cover all corners");
  s.corners.resize(s.triangles.size() * 3);
  std::vector<int> next(s.corner_begin.begin(), s.corner_begin.end() - 1);
  for (std::size_t t = 0; t < s.triangles.size(); t++)
    for (int corner = 0; corner < 3; corner++)
      s.corners[std::size_t(next[std::size_t(s.triangles[t][corner])]++)] = int(3 * t) + corner;
}

Status check_isolated(const Surface& s) {
  std::size_t count = 0, first = 0;
  for (std::size_t v = s.vertices.size(); v-- > 0;)
    if (corners_of(s, int(v)).empty()) count++, first = v;
  if (count == 0) return Done{};
  return Error{std::to_string(count) + " vertices belong to no triangle, the first of them is vertex " +
               std::to_string(first)};
}

std::string edge_text(const EdgeUse& edge) {
  return "the edge from vertex " + std::to_string(edge.a) + " to " + std::to_string(edge.b);
}

/// Finds the neighbor across every side.
Status join_sides(Surface& s) {
  s.across.assign(s.triangles.size() * 3, -1);
  std::size_t open = 0;
  std::string open_edge, crowded, flipped;
  const std::vector<EdgeUse> edges = sorted_edges(s.triangles);
  double length = 0;
  for_each_edge(std::span(edges), [&](std::span<const EdgeUse> uses) {
    // edge lengths
    const EdgeUse& u = uses[0];
    const double edge = norm(s.vertices[std::size_t(u.b)] - s.vertices[std::size_t(u.a)]);
    length += edge * double(uses.size()), s.longest_edge = std::max(s.longest_edge, edge);
    // faults: open, non-manifold, opposite orientations
    if (uses.size() == 1 && open++ == 0) open_edge = edge_text(u);
    if (uses.size() > 2 && crowded.empty())
      crowded = edge_text(u) + " has " + std::to_string(uses.size()) + " triangles, expected 2";
    if (uses.size() != 2) return;
    const EdgeUse& v = uses[1];
    if (u.forward == v.forward && flipped.empty())
      flipped = edge_text(u) + ": its triangles " + std::to_string(u.triangle) + " and " +
                std::to_string(v.triangle) + " have the same direction, expected opposite directions";
    // neighbors of each other
    s.across[std::size_t(3 * u.triangle + u.side)] = 3 * v.triangle + v.side;
    s.across[std::size_t(3 * v.triangle + v.side)] = 3 * u.triangle + u.side;
  });
  // result
  TURGOR_CHECK(!edges.empty(), "a mean is over at least one edge");
  s.mean_edge = length / double(edges.size());
  if (open > 0)
    return Error{"the surface is open: " + std::to_string(open) +
                 " edges have a triangle on one side only, the first is " + open_edge};
  if (!crowded.empty()) return Error{crowded};
  if (!flipped.empty()) return Error{flipped};
  return Done{};
}

/// Computes vertex normals, with each triangle weighted by its angle, so that they do not depend on the
/// triangulation.
Status set_normals(Surface& s) {
  s.normals.assign(s.vertices.size(), {});
  double volume = 0;
  for (std::size_t t = 0; t < s.triangles.size(); t++) {
    const auto x = [&](int corner) { return corner_position(s, int(t), corner); };
    // volume and area of the triangle
    const Vec3d n = cross(x(1) - x(0), x(2) - x(0));
    volume += dot(x(0), cross(x(1), x(2))) / 6;
    if (!(norm(n) > 0)) return Error{"triangle " + std::to_string(t) + " has no area"};
    // angle-weighted normals
    for (int i = 0; i < 3; i++) {
      const Vec3d e = x(i + 1) - x(i), f = x(i + 2) - x(i);
      s.normals[std::size_t(s.triangles[t][i])] += normalized(n) * std::atan2(norm(cross(e, f)), dot(e, f));
    }
  }
  for (Vec3d& n : s.normals) n = normalized(n);
  if (!(volume > 0)) return Error{"the surface is inside out: its triangles run clockwise seen from outside"};
  return Done{};
}

}  // namespace

Result<Surface> build_surface(std::vector<Vec3d> vertices, std::vector<Int3> triangles) {
  Surface surface{.vertices = std::move(vertices), .triangles = std::move(triangles)};
  if (const Status good = check_numbers(surface); !good) return good.error();
  gather_corners(surface);
  if (const Status good = check_isolated(surface); !good) return good.error();
  if (const Status good = join_sides(surface); !good) return good.error();
  if (const Status good = set_normals(surface); !good) return good.error();
  return surface;
}

}  // namespace turgor::rhombus
