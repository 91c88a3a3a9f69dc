// Sites where a sharp edge of one surface crosses a sharp edge of the other one. Vertices miss such contacts:
// of two planks that lie across each other, no vertex is inside the other plank. Where an edge touches a
// face, a vertex does too, or an edge of that face.
//
// Two segments touch along the normal n of both. Only crossings count whose n lies between the normals of the
// faces beside each edge; at all others, a vertex or a face is nearer.
#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "turgor/contact/pair_sites.hpp"
#include "turgor/geometry/box.hpp"

namespace turgor::contact {

namespace {

constexpr double kSharpCosine = 0.7;    // between the normals beside a sharp edge: 46 degrees
constexpr double kCrossingSine = 0.05;  // between two edges; below, vertices suffice
constexpr double kFromEnd = 1e-3;       // of an edge: nearer to its ends, a vertex touches
constexpr double kBeside = 1e-3;        // by which the normal of a crossing may leave the cone of an edge

/// Convex edge between two triangles.
struct SharpEdge {
  int from = 0, to = 0;  // vertices, along the first triangle
  Vec3d left, right;     // unit normals of the triangle that has the edge in this direction, and of the other
  int left_triangle = 0, right_triangle = 0;
};

Vec3d triangle_normal(const PairSurface& surface, Int3 t) {
  const auto at = [&](int v) { return surface.x[std::size_t(v)]; };
  return normalized(cross(at(t.y) - at(t.x), at(t.z) - at(t.x)));
}

/// Half of an edge: of one triangle.
struct HalfEdge {
  int low = 0, high = 0, triangle = 0, opposite = 0;
  bool rises = false;  // from the low to the high vertex
};

std::vector<HalfEdge> half_edges(const PairSurface& surface, const Box& within) {
  std::vector<HalfEdge> halves;
  for (std::size_t n = 0; n < surface.triangles.size(); n++) {
    const Int3 t = surface.triangles[n];
    const std::array<Vec3d, 3> corners{surface.x[std::size_t(t.x)], surface.x[std::size_t(t.y)],
                                       surface.x[std::size_t(t.z)]};
    if (!meet(within, box_around(corners))) continue;
    for (int corner = 0; corner < 3; corner++) {
      const int a = t[corner], b = t[(corner + 1) % 3];
      halves.push_back({std::min(a, b), std::max(a, b), int(n), t[(corner + 2) % 3], a < b});
    }
  }
  std::sort(halves.begin(), halves.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tuple(a.low, a.high, a.triangle) < std::tuple(b.low, b.high, b.triangle);
  });
  return halves;
}

/// Sharp convex edges in a box.
std::vector<SharpEdge> sharp_edges(const PairSurface& surface, const Box& within) {
  const std::vector<HalfEdge> halves = half_edges(surface, within);
  std::vector<SharpEdge> edges;
  for (std::size_t h = 0; h + 1 < halves.size(); h++) {
    const HalfEdge &a = halves[h], &b = halves[h + 1];
    if (a.low != b.low || a.high != b.high || a.rises == b.rises) continue;
    const Vec3d na = triangle_normal(surface, surface.triangles[std::size_t(a.triangle)]);
    const Vec3d nb = triangle_normal(surface, surface.triangles[std::size_t(b.triangle)]);
    const Vec3d across = surface.x[std::size_t(b.opposite)] - surface.x[std::size_t(b.low)];
    if (dot(na, nb) > kSharpCosine || dot(na, across) > 0) continue;
    edges.push_back(a.rises ? SharpEdge{a.low, a.high, na, nb, a.triangle, b.triangle}
                            : SharpEdge{a.low, a.high, nb, na, b.triangle, a.triangle});
  }
  return edges;
}

/// Crossing of two segments.
struct Crossing {
  double s = 0, t = 0;  // positions on them, from 0 to 1
  Vec3d normal;         // unit, from the second toward the first
  double height = 0;    // of the first above the second, negative inside [m]
};

/// True if a unit normal across an edge lies between the normals of its triangles.
bool is_between(const SharpEdge& edge, Vec3d n) {
  const Vec3d axis = normalized(cross(edge.left, edge.right));
  return dot(cross(edge.left, n), axis) >= -kBeside && dot(cross(n, edge.right), axis) >= -kBeside &&
         dot(n, edge.left + edge.right) > 0;
}

std::optional<Crossing> crossing_of(const PairSurface& first, const SharpEdge& a, const PairSurface& second,
                                    const SharpEdge& b) {
  const Vec3d pa = first.x[std::size_t(a.from)], ea = first.x[std::size_t(a.to)] - pa;
  const Vec3d pb = second.x[std::size_t(b.from)], eb = second.x[std::size_t(b.to)] - pb;
  Vec3d n = cross(ea, eb);
  const double size = norm(n);
  if (!(size > kCrossingSine * norm(ea) * norm(eb))) return {};
  n = n / size;
  if (dot(n, b.left + b.right) < 0) n = -n;
  if (!is_between(b, n) || !is_between(a, -n)) return {};
  // pa + s ea and pb + t eb differ along n only
  const Vec3d d = pb - pa;
  const double s = dot(cross(d, eb), n) / dot(cross(ea, eb), n);
  const double t = dot(cross(d, ea), n) / dot(cross(ea, eb), n);
  if (std::min(s, t) < kFromEnd || std::max(s, t) > 1 - kFromEnd) return {};
  return Crossing{s, t, n, dot(pa + ea * s - pb - eb * t, n)};
}

/// Distance that is kept at a crossing: less where the same edges of two deformable bodies crossed nearer at
/// rest, or overlapped there.
double kept_at_crossing(const std::array<PairSurface, 2>& surfaces, const SharpEdge& a, const SharpEdge& b,
                        double gap) {
  if (surfaces[0].rest_height.empty() || surfaces[1].rest_height.empty()) return gap;
  std::array<PairSurface, 2> rest = surfaces;
  for (PairSurface& surface : rest) surface.x = surface.rest;
  const auto at_rest = [](const PairSurface& surface, SharpEdge edge) {
    edge.left = triangle_normal(surface, surface.triangles[std::size_t(edge.left_triangle)]);
    edge.right = triangle_normal(surface, surface.triangles[std::size_t(edge.right_triangle)]);
    return edge;
  };
  const std::optional<Crossing> crossing =
      crossing_of(rest[0], at_rest(rest[0], a), rest[1], at_rest(rest[1], b));
  return crossing ? std::min(gap, crossing->height) : gap;
}

/// Depth below which two edges are taken to cross elsewhere; tissue is thinner than its mesh's largest edges.
double deepest_at_crossing(const std::array<PairSurface, 2>& surfaces, const SharpEdge& a, const SharpEdge& b,
                           double deepest) {
  constexpr double kOfShorter = 0.5;  // edge
  if (surfaces[0].rest_height.empty() || surfaces[1].rest_height.empty()) return deepest;
  const auto length = [](const PairSurface& surface, const SharpEdge& edge) {
    return norm(surface.x[std::size_t(edge.to)] - surface.x[std::size_t(edge.from)]);
  };
  return std::min(deepest, kOfShorter * std::min(length(surfaces[0], a), length(surfaces[1], b)));
}

SurfacePoint edge_point(const PairSurface& surface, const SharpEdge& edge, double along) {
  const Vec3d from = surface.rest[std::size_t(edge.from)], to = surface.rest[std::size_t(edge.to)];
  return {surface.body, {edge.from, edge.to, -1}, {1 - along, along, 0}, from + (to - from) * along};
}

/// Keeps the point of the first edge at which the same two edges stuck, if they still cross near it.
void keep_sticking_point(const PairSurface& first, std::span<const PairSite> last, PairSite& site) {
  constexpr double kSameCrossing = 0.01;  // of an edge
  const auto same = [](Int3 a, Int3 b) { return a.x == b.x && a.y == b.y; };
  for (const PairSite& before : last) {
    if (before.a.body != site.a.body || !same(before.a.vertex, site.a.vertex) ||
        !same(before.b.vertex, site.b.vertex) || before.state != SiteState::kStick)
      continue;
    const double moved = before.a.weight.y - site.a.weight.y;
    if (std::abs(moved) > kSameCrossing) return;
    const auto at = [&](int v) { return first.x[std::size_t(v)]; };
    site.a = before.a, site.found += (at(site.a.vertex.y) - at(site.a.vertex.x)) * moved;
    site.slip = site.found;
    return;
  }
}

Box grown_box(Box box, double by) {
  box.low -= Vec3d{by, by, by}, box.high += Vec3d{by, by, by};
  return box;
}

}  // namespace

std::vector<PairSite> find_edge_sites(const std::array<PairSurface, 2>& surfaces, const PairParams& params,
                                      std::span<const PairSite> last) {
  const double far = params.reach + params.deepest;
  const auto& [first, second] = surfaces;
  const std::vector<SharpEdge> of_first = sharp_edges(first, grown_box(box_around(second.x), far));
  const std::vector<SharpEdge> of_second = sharp_edges(second, grown_box(box_around(first.x), far));
  std::vector<PairSite> sites;
  for (const SharpEdge& a : of_first)
    for (const SharpEdge& b : of_second) {
      const std::optional<Crossing> crossing = crossing_of(first, a, second, b);
      if (!crossing || crossing->height < -deepest_at_crossing(surfaces, a, b, params.deepest)) continue;
      const double kept = kept_at_crossing(surfaces, a, b, params.gap);
      if (crossing->height - kept > params.reach) continue;
      PairSite site{.a = edge_point(first, a, crossing->s),
                    .b = edge_point(second, b, crossing->t),
                    .anchor = {},
                    .slip = crossing->normal * crossing->height,
                    .normal = crossing->normal,
                    .distance = crossing->height - kept,
                    .found = crossing->normal * crossing->height,
                    .friction = params.friction,
                    .force = {}};
      site.anchor = site.b;
      keep_sticking_point(first, last, site);
      sites.push_back(site);
    }
  return sites;
}

}  // namespace turgor::contact
