#include "turgor/contact/pair_sites.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/box.hpp"

namespace turgor::contact {

namespace {

constexpr double kSameVertex = 0.3;  // of an edge: sites of both surfaces that are nearer are one
constexpr double kFacing = -0.4;     // cosine between the normals of surfaces that can touch
constexpr double kOnSurface = 1e-6;  // of an edge: distance below which the normal is the surface's

/// A surface with what the search needs.
struct Searched {
  const PairSurface& surface;
  std::vector<int> vertices;        // of its triangles, ascending
  std::vector<Vec3d> normals;       // of every vertex of the mesh, weighted by area
  std::vector<std::size_t> around;  // first entry of each vertex in `triangles`, and an end
  std::vector<int> triangles;       // around each vertex, ascending
  TriangleTree tree;
  double edge = 0;  // mean [m]
};

Vec3d area_normal(const PairSurface& surface, Int3 t) {
  const Vec3d a = surface.x[std::size_t(t.x)];
  return cross(surface.x[std::size_t(t.y)] - a, surface.x[std::size_t(t.z)] - a);
}

Searched searched(const PairSurface& surface) {
  Searched s{.surface = surface, .vertices = {}, .normals = {}, .around = {}, .triangles = {}, .tree = {}};
  // vertices and their normals
  s.normals.resize(surface.x.size()), s.around.resize(surface.x.size() + 1);
  for (const Int3 t : surface.triangles)
    for (const int v : {t.x, t.y, t.z}) {
      s.normals[std::size_t(v)] += area_normal(surface, t);
      s.around[std::size_t(v) + 1]++;
      s.vertices.push_back(v);
    }
  sort_unique(s.vertices);
  // triangles around each vertex
  for (std::size_t v = 0; v < surface.x.size(); v++) s.around[v + 1] += s.around[v];
  std::vector<std::size_t> next(s.around.begin(), s.around.end() - 1);
  s.triangles.resize(3 * surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); t++)
    for (int corner = 0; corner < 3; corner++)
      s.triangles[next[std::size_t(surface.triangles[t][corner])]++] = int(t);
  s.tree = build_triangle_tree({surface.x.begin(), surface.x.end()},
                               {surface.triangles.begin(), surface.triangles.end()});
  s.edge = mean_edge(surface.x, surface.triangles);
  return s;
}

/// A vertex and the nearest point of the other surface.
struct Near {
  TrianglePoint point;
  Vec3d normal;       // of the other surface, or toward the vertex
  double height = 0;  // above the other surface, negative inside [m]
  bool faces = false;
};

/// True if a triangle has all corners that carry a point on an edge or a corner.
bool carries(Int3 t, Int3 of, Vec3d weights) {
  for (int corner = 0; corner < 3; corner++)
    if (weights[corner] > 0 && t.x != of[corner] && t.y != of[corner] && t.z != of[corner]) return false;
  return true;
}

/// Normal of the triangle at a surface point that faces a direction most. A point on an edge or a corner is
/// in several triangles.
Vec3d facing_normal(const Searched& other, const TrianglePoint& point, Vec3d direction) {
  const Int3 t = other.surface.triangles[std::size_t(point.triangle)];
  const Vec3d w = point.weights;
  Vec3d best = normalized(area_normal(other.surface, t));
  if (w.x > 0 && w.y > 0 && w.z > 0) return best;
  const auto v = std::size_t(w.x > 0 ? t.x : w.y > 0 ? t.y : t.z);
  for (std::size_t n = other.around[v]; n < other.around[v + 1]; n++) {
    const Int3 neighbor = other.surface.triangles[std::size_t(other.triangles[n])];
    const Vec3d normal = normalized(area_normal(other.surface, neighbor));
    if (carries(neighbor, t, w) && dot(normal, direction) < dot(best, direction)) best = normal;
  }
  return best;
}

Near nearest(const Searched& other, Vec3d x, Vec3d own_normal) {
  Near near{.point = nearest_point(other.tree, x), .normal = {}};
  const Int3 t = other.surface.triangles[std::size_t(near.point.triangle)];
  // signed height, by the mean normal of the vertices where the point is on an edge
  const Vec3d w = near.point.weights, own = normalized(own_normal);
  Vec3d mean = area_normal(other.surface, t);
  if (!(w.x > 0 && w.y > 0 && w.z > 0)) {
    mean = {};
    for (int corner = 0; corner < 3; corner++)
      mean += normalized(other.normals[std::size_t(t[corner])]) * w[corner];
  }
  const Vec3d apart = x - near.point.position;
  const double sign = dot(apart, mean) < 0 ? -1 : 1;
  near.height = sign * near.point.distance;
  // normal along the line between the points where they are apart
  const Vec3d facing = facing_normal(other, near.point, own);
  near.normal = near.point.distance > kOnSurface * other.edge ? apart * (sign / near.point.distance) : facing;
  near.faces = dot(own, near.normal) < kFacing && dot(own, facing) < kFacing;
  return near;
}

/// Distance that is kept at a vertex or node: less where the surfaces were nearer at rest.
double kept_distance(std::span<const double> rest_height, int v, double gap) {
  return rest_height.empty() ? gap : std::min(gap, rest_height[std::size_t(v)]);
}

SurfacePoint vertex_point(const PairSurface& surface, int v) {
  return {surface.body, {v, -1, -1}, {1, 0, 0}, surface.rest[std::size_t(v)]};
}
SurfacePoint triangle_point(const PairSurface& surface, const TrianglePoint& point) {
  const Int3 t = surface.triangles[std::size_t(point.triangle)];
  SurfacePoint p{surface.body, t, point.weights, {}};
  for (int corner = 0; corner < 3; corner++)
    p.rest += surface.rest[std::size_t(t[corner])] * point.weights[corner];
  return p;
}
Vec3d position_of(const PairSurface& surface, const SurfacePoint& point) {
  Vec3d x;
  for (int corner = 0; corner < 3; corner++)
    if (point.vertex[corner] >= 0) x += surface.x[std::size_t(point.vertex[corner])] * point.weight[corner];
  return x;
}

/// Sites of the vertices of one surface.
void add_sites(const Exec& exec, const Searched& from, const Searched& to, const PairParams& params,
               std::vector<PairSite>& sites) {
  // nearest points, in parallel
  const Box box = box_around(to.surface.x);
  std::vector<Near> near(from.vertices.size());
  parallel_for(
      exec, near.size(),
      [&](std::size_t n) {
        const Vec3d x = from.surface.x[std::size_t(from.vertices[n])];
        if (squared_distance(box, x) <= params.reach * params.reach)
          near[n] = nearest(to, x, from.normals[std::size_t(from.vertices[n])]);
      },
      64);
  // sites in the order of the vertices
  for (std::size_t n = 0; n < near.size(); n++) {
    const int v = from.vertices[n];
    const double kept = kept_distance(from.surface.rest_height, v, params.gap);
    if (!near[n].faces || near[n].height - kept > params.reach || near[n].height < -params.deepest) continue;
    PairSite site{.a = vertex_point(from.surface, v),
                  .b = triangle_point(to.surface, near[n].point),
                  .anchor = {},
                  .slip = {},
                  .normal = near[n].normal,
                  .distance = near[n].height - kept,
                  .found = {},
                  .friction = params.friction,
                  .force = {}};
    site.found = position_of(from.surface, site.a) - position_of(to.surface, site.b);
    site.anchor = site.b, site.slip = site.found;
    sites.push_back(site);
  }
}

/// Nearest points of the second surface of all nodes within reach.
std::vector<Near> nearest_of_nodes(const Exec& exec, const SurfaceNodes& nodes, const Searched& own,
                                   const Searched& other, double reach) {
  const Box box = box_around(other.surface.x);
  std::vector<Near> near(nodes.x.size());
  parallel_for(
      exec, near.size(),
      [&](std::size_t n) {
        const Vec3d normal = own.normals[std::size_t(nodes.vertex[n])];
        if (normal != Vec3d{} && squared_distance(box, nodes.x[n]) <= reach * reach)
          near[n] = nearest(other, nodes.x[n], normal);
      },
      64);
  return near;
}

PairSite node_site(const SurfaceNodes& nodes, std::size_t n, int body, Vec3d normal, double height,
                   const PairParams& params) {
  const double kept = kept_distance(nodes.rest_height, int(n), params.gap);
  PairSite site{.a = {body, {nodes.vertex[n], -1, -1}, {1, 0, 0}, nodes.rest[n]},
                .b = {},
                .anchor = {},
                .slip = {},
                .normal = normal,
                .distance = height - kept,
                .found = {},
                .friction = params.friction,
                .force = {}};
  site.node = int(n);
  return site;
}

/// Sites of nodes with the forces of the last ones, which ascend by node.
PairSites continued_nodes(std::vector<PairSite> sites, std::span<const PairSite> last) {
  PairSites found{.sites = std::move(sites)};
  auto before = last.begin();
  for (PairSite& site : found.sites) {
    while (before != last.end() && before->node < site.node) ++before;
    if (before != last.end() && before->node == site.node)
      site.force = before->force, site.state = before->state;
    found.deepest = std::max(found.deepest, -site.distance);
  }
  return found;
}

/// Removes sites of the second surface that meet a vertex of the first, which has a site itself.
void remove_doubles(const std::array<PairSurface, 2>& surfaces, double edge, std::size_t first_count,
                    std::vector<PairSite>& sites) {
  constexpr double kWider = 1 + 1e-9;  // window of the search, against rounding
  if (first_count == 0) return;
  // vertices of the first, sorted along the longest side of their box
  std::vector<Vec3d> first;
  for (std::size_t s = 0; s < first_count; s++) first.push_back(position_of(surfaces[0], sites[s].a));
  const Box box = box_around(first);
  const Vec3d side = box.high - box.low;
  const int axis = side.x >= side.y && side.x >= side.z ? 0 : side.y >= side.z ? 1 : 2;
  std::sort(first.begin(), first.end(), [axis](Vec3d a, Vec3d b) { return a[axis] < b[axis]; });
  // sites of the second near one of them
  const double near = kSameVertex * edge;
  const auto is_double = [&](const PairSite& site) {
    const Vec3d x = position_of(surfaces[0], site.b);
    auto other = std::partition_point(first.begin(), first.end(),
                                      [&](Vec3d v) { return v[axis] < x[axis] - kWider * near; });
    for (; other != first.end() && (*other)[axis] <= x[axis] + kWider * near; ++other)
      if (norm(*other - x) < near) return true;
    return false;
  };
  sites.erase(std::remove_if(sites.begin() + std::ptrdiff_t(first_count), sites.end(), is_double),
              sites.end());
}

/// Vertex, or both edges, by which a site is known in the next frame.
auto site_key(const PairSite& site) {
  const bool is_edge = site.a.vertex.y >= 0;
  return std::tuple(site.a.body, site.a.vertex.x, site.a.vertex.y, is_edge ? site.b.vertex.x : -1,
                    is_edge ? site.b.vertex.y : -1);
}

/// Takes over the forces of the same vertex or crossing, and its anchor while it sticks at the same point.
void continue_sites(std::span<const PairSite> last, std::vector<PairSite>& sites) {
  std::map<decltype(site_key(sites[0])), const PairSite*> known;
  for (const PairSite& site : last) known[site_key(site)] = &site;
  for (PairSite& site : sites) {
    const auto found = known.find(site_key(site));
    if (found == known.end()) continue;
    const PairSite& before = *found->second;
    site.force = before.force, site.borne = before.borne;
    if (before.state == SiteState::kStick && !site.rolls && site.a.weight == before.a.weight)
      site.anchor = before.anchor, site.slip = before.slip;
  }
}

/// Nearest sites within the capacity, with the forces and anchors of the last ones.
PairSites chosen_sites(std::vector<PairSite> sites, const PairParams& params,
                       std::span<const PairSite> last) {
  PairSites found{.sites = std::move(sites)};
  const auto most = std::size_t(params.capacity);
  if (found.sites.size() > most) {
    std::stable_sort(found.sites.begin(), found.sites.end(),
                     [](const PairSite& a, const PairSite& b) { return a.distance < b.distance; });
    for (std::size_t s = most; s < found.sites.size(); s++) found.dropped += found.sites[s].distance <= 0;
    found.sites.resize(most);
  }
  for (const PairSite& site : found.sites) found.deepest = std::max(found.deepest, -site.distance);
  continue_sites(last, found.sites);
  return found;
}

}  // namespace

PairSites find_pair_sites(const Exec& exec, const std::array<PairSurface, 2>& surfaces,
                          const PairParams& params, std::span<const PairSite> last) {
  if (surfaces[0].round || surfaces[1].round)
    return chosen_sites(find_round_sites(surfaces, params), params, last);
  const Searched first = searched(surfaces[0]), second = searched(surfaces[1]);
  // both directions
  std::vector<PairSite> sites;
  add_sites(exec, first, second, params, sites);
  const std::size_t first_count = sites.size();
  add_sites(exec, second, first, params, sites);
  remove_doubles(surfaces, std::min(first.edge, second.edge), first_count, sites);
  // sharp edges
  const std::vector<PairSite> crossings = find_edge_sites(surfaces, params, last);
  sites.insert(sites.end(), crossings.begin(), crossings.end());
  return chosen_sites(std::move(sites), params, last);
}

PairSites find_ground_sites(const PairSurface& surface, const GroundPlane& ground, const PairParams& params,
                            std::span<const PairSite> last) {
  return chosen_sites(ground_sites(surface, ground, params), params, last);
}

PairSites find_node_sites(const Exec& exec, const SurfaceNodes& nodes,
                          const std::array<PairSurface, 2>& surfaces, const PairParams& params,
                          std::span<const PairSite> last) {
  if (surfaces[1].round) return continued_nodes(find_round_node_sites(nodes, surfaces, params), last);
  const Searched own = searched(surfaces[0]), other = searched(surfaces[1]);
  const std::vector<Near> near = nearest_of_nodes(exec, nodes, own, other, params.reach);
  std::vector<PairSite> sites;
  for (std::size_t n = 0; n < near.size(); n++) {
    if (!near[n].faces || near[n].height < -params.deepest) continue;
    PairSite site = node_site(nodes, n, surfaces[0].body, near[n].normal, near[n].height, params);
    if (site.distance > params.reach) continue;
    site.b = triangle_point(surfaces[1], near[n].point);
    site.found = nodes.x[n] - near[n].point.position;
    sites.push_back(site);
  }
  return continued_nodes(std::move(sites), last);
}

PairSites find_node_sites(const SurfaceNodes& nodes, int index, const GroundPlane& ground,
                          const PairParams& params, std::span<const PairSite> last) {
  std::vector<PairSite> sites;
  for (std::size_t n = 0; n < nodes.x.size(); n++) {
    const double height = dot(nodes.x[n] - ground.through, ground.normal);
    PairSite site = node_site(nodes, n, index, ground.normal, height, params);
    if (site.distance > params.reach) continue;
    site.b.rest = nodes.x[n] - height * ground.normal, site.found = height * ground.normal;
    sites.push_back(site);
  }
  return continued_nodes(std::move(sites), last);
}

std::vector<double> rest_heights(const Exec& exec, const SurfaceNodes& nodes,
                                 const std::array<PairSurface, 2>& surfaces, const PairParams& params) {
  const Searched own = searched(surfaces[0]), other = searched(surfaces[1]);
  std::vector<double> heights;
  for (const Near& near : nearest_of_nodes(exec, nodes, own, other, params.reach + params.deepest))
    heights.push_back(near.faces && near.height >= -params.deepest ? std::min(params.reach, near.height)
                                                                   : params.reach);
  return heights;
}

std::vector<double> rest_heights(const Exec& exec, const PairSurface& of, const PairSurface& above,
                                 double reach, double deepest) {
  const Searched from = searched(of), to = searched(above);
  std::vector<double> heights(of.x.size(), reach);
  parallel_for(
      exec, from.vertices.size(),
      [&](std::size_t n) {
        const auto v = std::size_t(from.vertices[n]);
        const Near near = nearest(to, of.x[v], from.normals[v]);
        if (near.faces && near.height >= -deepest) heights[v] = std::min(reach, near.height);
      },
      64);
  return heights;
}

double mean_edge(std::span<const Vec3d> x, std::span<const Int3> triangles) {
  double sum = 0;
  for (const Int3 t : triangles)
    for (int corner = 0; corner < 3; corner++)
      sum += norm(x[std::size_t(t[corner])] - x[std::size_t(t[(corner + 1) % 3])]);
  return triangles.empty() ? 0 : sum / (3 * double(triangles.size()));
}

}  // namespace turgor::contact
