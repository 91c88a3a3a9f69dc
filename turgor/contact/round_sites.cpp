// Sites of balls and capsules, which touch by the segment and the radius that they are made of, and sites on
// the ground. A point of a segment that meets a surface rolls over it: its material point changes from frame
// to frame.
#include <algorithm>
#include <cmath>
#include <utility>

#include "turgor/contact/pair_sites.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/box.hpp"

namespace turgor::contact {

namespace {

constexpr double kFacingRound = -0.4;  // cosine between the normals of surfaces that can touch
constexpr double kSameSite = 0.3;      // of an edge or a radius: nearer sites are one
constexpr int kMostCenters = 16;       // along a capsule

/// True if the segment is a point; its ends may differ by rounding.
bool is_ball(const RoundSurface& round) {
  constexpr double kPoint = 1e-6;  // of the radius
  return norm(round.ends[1] - round.ends[0]) <= kPoint * round.radius;
}

/// Centers along a segment, at most `apart` from each other within kMostCenters.
std::vector<Vec3d> centers_of(const RoundSurface& round, double apart) {
  const double length = norm(round.ends[1] - round.ends[0]);
  if (is_ball(round)) return {round.ends[0]};
  const int count = std::clamp(1 + int(std::ceil(length / apart)), 2, kMostCenters);
  std::vector<Vec3d> centers;
  for (int n = 0; n < count; n++)
    centers.push_back(round.ends[0] + (round.ends[1] - round.ends[0]) * (double(n) / (count - 1)));
  return centers;
}

Vec3d nearest_on(const RoundSurface& round, Vec3d x) {
  const Vec3d along = round.ends[1] - round.ends[0];
  const double square = dot(along, along);
  if (is_ball(round)) return round.ends[0];
  return round.ends[0] + along * std::clamp(dot(x - round.ends[0], along) / square, 0.0, 1.0);
}

/// Nearest points of two segments e₀ + s p and a + t q; of parallel ones, those next to the middle of the
/// second. With r = e₀ − a, both derivatives of |r + s p − t q|² vanish at
///   s = ((p·q)(q·r) − (p·r)(q·q)) / ((p·p)(q·q) − (p·q)²),  t = ((p·q) s + q·r)/(q·q)
/// A t outside of the second segment is clamped, and s follows. [Ericson 2005, 5.1.9]
std::pair<Vec3d, Vec3d> nearest_points(const RoundSurface& first, Vec3d a, Vec3d b) {
  constexpr double kParallel = 1e-12;  // squared sine
  const Vec3d p = first.ends[1] - first.ends[0], q = b - a, r = first.ends[0] - a;
  const double pp = dot(p, p), qq = dot(q, q), pq = dot(p, q), pr = dot(p, r), qr = dot(q, r);
  TURGOR_CHECK(pp > 0 && qq > 0, "segments have a length");
  const double determinant = pp * qq - pq * pq;
  double s = determinant > kParallel * pp * qq ? (pq * qr - pr * qq) / determinant : (0.5 * pq - pr) / pp;
  s = std::clamp(s, 0.0, 1.0);
  const double along = (pq * s + qr) / qq, t = std::clamp(along, 0.0, 1.0);
  if (t != along) s = std::clamp((pq * t - pr) / pp, 0.0, 1.0);
  return {first.ends[0] + p * s, a + q * t};
}
std::pair<Vec3d, Vec3d> nearest_points(const RoundSurface& first, const RoundSurface& second) {
  if (is_ball(first)) return {first.ends[0], nearest_on(second, first.ends[0])};
  if (is_ball(second)) return {nearest_on(first, second.ends[0]), second.ends[0]};
  return nearest_points(first, second.ends[0], second.ends[1]);
}

/// Unit vector from `from` to `to`; a fallback where they coincide.
Vec3d direction(Vec3d from, Vec3d to, Vec3d fallback) {
  const Vec3d d = to - from;
  return norm(d) > 0 ? normalized(d) : fallback;
}

/// Material point of a round surface at a present position; the number identifies it.
SurfacePoint material_point(const PairSurface& surface, Vec3d x, int number) {
  return {surface.body, {number, -1, -1}, {1, 0, 0}, to_tool(surface.round->pose, x)};
}
/// The same as a rolling point, which keeps its offset from a center on the segment.
SurfacePoint rolling_point(const PairSurface& surface, Vec3d center, Vec3d offset, int number) {
  SurfacePoint point = material_point(surface, center, number);
  point.offset = offset;
  return point;
}

/// Completes a site of points at these positions.
PairSite made_site(const SurfacePoint& a, Vec3d x_a, const SurfacePoint& b, Vec3d x_b, Vec3d normal,
                   double distance, const PairParams& params) {
  return {.a = a,
          .b = b,
          .anchor = b,
          .slip = x_a - x_b,
          .normal = normal,
          .distance = distance - params.gap,
          .found = x_a - x_b,
          .friction = params.friction,
          .force = {}};
}
bool is_within(double distance, const PairParams& params) {
  return distance - params.gap <= params.reach && distance >= -params.deepest;
}

/// Outward normals of the vertices, weighted by area.
std::vector<Vec3d> outward_normals(const PairSurface& mesh) {
  std::vector<Vec3d> normals(mesh.x.size());
  for (const Int3 t : mesh.triangles) {
    const Vec3d a = mesh.x[std::size_t(t.x)];
    const Vec3d n = cross(mesh.x[std::size_t(t.y)] - a, mesh.x[std::size_t(t.z)] - a);
    for (const int v : {t.x, t.y, t.z}) normals[std::size_t(v)] += n;
  }
  for (Vec3d& n : normals) n = normalized(n);
  return normals;
}

std::vector<int> used_vertices(const PairSurface& mesh) {
  std::vector<int> vertices;
  for (const Int3 t : mesh.triangles) vertices.insert(vertices.end(), {t.x, t.y, t.z});
  sort_unique(vertices);
  return vertices;
}

/// Vertices of a mesh that are near a round surface.
void add_vertex_sites(const PairSurface& mesh, const std::vector<Vec3d>& normals, const PairSurface& round,
                      const PairParams& params, std::vector<PairSite>& sites) {
  for (const int v : used_vertices(mesh)) {
    const Vec3d x = mesh.x[std::size_t(v)], own = normals[std::size_t(v)];
    const Vec3d center = nearest_on(*round.round, x);
    const double distance = norm(x - center) - round.round->radius;
    const Vec3d normal = direction(center, x, -own);
    if (!is_within(distance, params) || dot(own, normal) > kFacingRound) continue;
    const Vec3d at = center + normal * round.round->radius;
    const SurfacePoint a{mesh.body, {v, -1, -1}, {1, 0, 0}, mesh.rest[std::size_t(v)]};
    const SurfacePoint b = rolling_point(round, center, normal * round.round->radius, 0);
    sites.push_back(made_site(a, x, b, at, normal, distance, params));
    sites.back().anchor = material_point(round, at, 0);
  }
}

/// True if all corners of a triangle have sites.
bool touches_all(Int3 t, const std::vector<PairSite>& sites) {
  const auto has_site = [&](int v) {
    return std::any_of(sites.begin(), sites.end(),
                       [v](const PairSite& site) { return !site.rolls && site.a.vertex.x == v; });
  };
  return has_site(t.x) && has_site(t.y) && has_site(t.z);
}

/// Point of a segment at which a site is searched. The number identifies it from frame to frame.
struct Center {
  Vec3d x;
  int number = 0;
};

/// Points of a capsule's segment next to edges of a mesh that are longer than its radius; shorter ones are
/// met by their vertices. An edge of two triangles is listed twice.
std::vector<Center> centers_at_edges(const PairSurface& mesh, const RoundSurface& round,
                                     const PairParams& params) {
  std::vector<Center> centers;
  if (is_ball(round)) return centers;
  const double far = round.radius + params.gap + params.reach;
  Box within = box_around(round.ends);
  within.low -= Vec3d{far, far, far}, within.high += Vec3d{far, far, far};
  for (std::size_t n = 0; n < mesh.triangles.size(); n++)
    for (int corner = 0; corner < 3; corner++) {
      const Int3 t = mesh.triangles[n];
      const std::array<Vec3d, 2> edge{mesh.x[std::size_t(t[corner])],
                                      mesh.x[std::size_t(t[(corner + 1) % 3])]};
      if (!meet(within, box_around(edge)) || norm(edge[1] - edge[0]) <= round.radius) continue;
      const auto [center, on_edge] = nearest_points(round, edge[0], edge[1]);
      if (norm(center - on_edge) <= far) centers.push_back({center, kMostCenters + 1 + 3 * int(n) + corner});
    }
  return centers;
}

/// Adds sites of points of a segment that are near a mesh, unless another site is there. In a dent of a mesh
/// with `by_vertices`, the nearest point of a segment would jump from triangle to triangle, and push a ball
/// to and fro.
void add_center_sites(const PairSurface& mesh, const std::vector<Vec3d>& normals, const PairSurface& round,
                      const PairParams& params, std::vector<PairSite>& sites) {
  const double edge = mean_edge(mesh.x, mesh.triangles), radius = round.round->radius;
  const TriangleTree tree =
      build_triangle_tree({mesh.x.begin(), mesh.x.end()}, {mesh.triangles.begin(), mesh.triangles.end()});
  std::vector<Vec3d> taken, added;
  for (const PairSite& site : sites) taken.push_back(mesh.x[std::size_t(site.a.vertex.x)]);
  const auto add = [&](const Center& center) {
    // signed distance of the center
    const TrianglePoint near = nearest_point(tree, center.x);
    const Int3 t = mesh.triangles[std::size_t(near.triangle)];
    SurfacePoint b{mesh.body, t, near.weights, {}};
    Vec3d outward;
    for (int corner = 0; corner < 3; corner++) {
      b.rest += mesh.rest[std::size_t(t[corner])] * near.weights[corner];
      outward += normals[std::size_t(t[corner])] * near.weights[corner];
    }
    const double sign = dot(center.x - near.position, outward) < 0 ? -1 : 1;
    const double distance = sign * near.distance - radius;
    if (!is_within(distance, params)) return;
    const bool is_double = std::any_of(taken.begin(), taken.end(), [&](Vec3d x) {
      return norm(x - near.position) < kSameSite * std::min(edge, radius);
    });
    if (is_double || (mesh.by_vertices && touches_all(t, sites))) return;
    // the round surface has the first point, so that the normal points toward it
    const Vec3d normal = sign * direction(near.position, center.x, sign * normalized(outward));
    const Vec3d at = center.x - normal * radius;
    PairSite site = made_site(rolling_point(round, center.x, normal * -radius, center.number), at, b,
                              near.position, normal, distance, params);
    site.rolls = true;
    sites.push_back(site), added.push_back(near.position);
  };
  // along the segment
  int number = 0;
  for (const Vec3d x : centers_of(*round.round, std::max(radius, edge))) add({x, ++number});
  // next to edges that pass between these points
  for (const Center& center : centers_at_edges(mesh, *round.round, params)) {
    taken.insert(taken.end(), added.begin(), added.end()), added.clear();
    add(center);
  }
}

/// Adds sites at the nearest points of two segments, and at their ends with the nearest points of the other
/// one.
void add_round_pairs(const PairSurface& first, const PairSurface& second, const PairParams& params,
                     std::vector<PairSite>& sites) {
  const RoundSurface &a = *first.round, &b = *second.round;
  const double radii = a.radius + b.radius;
  // candidates: centers on both
  std::vector<std::pair<Vec3d, Vec3d>> pairs{nearest_points(a, b)};
  for (const Vec3d end : a.ends) pairs.emplace_back(end, nearest_on(b, end));
  for (const Vec3d end : b.ends) pairs.emplace_back(nearest_on(a, end), end);
  // sites that differ
  std::vector<Vec3d> taken;
  int number = 0;
  for (const auto& [x, y] : pairs) {
    number++;
    const double distance = norm(x - y) - radii;
    const bool is_double = std::any_of(taken.begin(), taken.end(), [&, x = x](Vec3d t) {
      return norm(x - t) < kSameSite * std::min(a.radius, b.radius);
    });
    if (is_double || !is_within(distance, params)) continue;
    taken.push_back(x);
    const Vec3d normal = direction(y, x, {0, 0, 1});
    const Vec3d at = x - normal * a.radius, on = y + normal * b.radius;
    PairSite site =
        made_site(rolling_point(first, x, normal * -a.radius, number), at,
                  rolling_point(second, y, normal * b.radius, number), on, normal, distance, params);
    site.rolls = true;
    sites.push_back(site);
  }
}

}  // namespace

std::vector<PairSite> find_round_sites(const std::array<PairSurface, 2>& surfaces, const PairParams& params) {
  std::vector<PairSite> sites;
  if (surfaces[0].round && surfaces[1].round) {
    add_round_pairs(surfaces[0], surfaces[1], params, sites);
    return sites;
  }
  const std::size_t round = surfaces[0].round ? 0 : 1;
  TURGOR_CHECK(surfaces[round].round, "one of the surfaces is round");
  const PairSurface& mesh = surfaces[1 - round];
  const std::vector<Vec3d> normals = outward_normals(mesh);
  add_vertex_sites(mesh, normals, surfaces[round], params, sites);
  add_center_sites(mesh, normals, surfaces[round], params, sites);
  return sites;
}

std::vector<PairSite> find_round_node_sites(const SurfaceNodes& nodes,
                                            const std::array<PairSurface, 2>& surfaces,
                                            const PairParams& params) {
  const RoundSurface& round = *surfaces[1].round;
  const std::vector<Vec3d> normals = outward_normals(surfaces[0]);
  std::vector<PairSite> sites;
  for (std::size_t n = 0; n < nodes.x.size(); n++) {
    const Vec3d x = nodes.x[n], own = normals[std::size_t(nodes.vertex[n])];
    if (!(dot(own, own) > 0)) continue;  // far from the other surface
    const Vec3d center = nearest_on(round, x);
    const double distance = norm(x - center) - round.radius;
    const Vec3d normal = direction(center, x, -own);
    if (!is_within(distance, params) || dot(own, normal) > kFacingRound) continue;
    const Vec3d at = center + normal * round.radius;
    const SurfacePoint a{surfaces[0].body, {nodes.vertex[n], -1, -1}, {1, 0, 0}, nodes.rest[n]};
    sites.push_back(made_site(a, x, material_point(surfaces[1], at, 0), at, normal, distance, params));
    sites.back().node = int(n);
  }
  return sites;
}

std::vector<PairSite> ground_sites(const PairSurface& surface, const GroundPlane& ground,
                                   const PairParams& params) {
  std::vector<PairSite> sites;
  const auto add = [&](const SurfacePoint& a, Vec3d x, bool rolls) {
    const double height = dot(x - ground.through, ground.normal);
    if (height - params.gap > params.reach) return;
    const SurfacePoint b{.body = -1, .weight = {}, .rest = x - ground.normal * height};
    sites.push_back(made_site(a, x, b, b.rest, ground.normal, height, params));
    sites.back().rolls = rolls;
  };
  if (!surface.round) {
    for (const int v : used_vertices(surface))
      add({surface.body, {v, -1, -1}, {1, 0, 0}, surface.rest[std::size_t(v)]}, surface.x[std::size_t(v)],
          false);
    return sites;
  }
  // the lowest points of a ball, or of the two ends of a capsule
  const RoundSurface& round = *surface.round;
  for (std::size_t end = 0; end < (is_ball(round) ? 1U : 2U); end++) {
    const Vec3d offset = ground.normal * -round.radius;
    add(rolling_point(surface, round.ends[end], offset, int(end)), round.ends[end] + offset, true);
  }
  return sites;
}

}  // namespace turgor::contact
