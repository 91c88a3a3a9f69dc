#include "turgor/contact/pair_sites.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "turgor/contact/facing_point.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/geometry/box.hpp"

namespace turgor::contact {

namespace {

constexpr double kSameVertex = 0.3;  // of the shortest edge: sites of both surfaces that are nearer are one

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
void add_sites(const Exec& exec, const SearchedSurface& from, const SearchedSurface& to,
               const PairParams& params, std::vector<PairSite>& sites) {
  // nearest points, in parallel
  const Box box = box_around(to.surface.x);
  std::vector<FacingPoint> near(from.vertices.size());
  parallel_for(
      exec, near.size(),
      [&](std::size_t n) {
        const Vec3d x = from.surface.x[std::size_t(from.vertices[n])];
        if (squared_distance(box, x) <= params.reach * params.reach)
          near[n] = facing_point(to, x, from, from.vertices[n]);
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
std::vector<FacingPoint> nearest_of_nodes(const Exec& exec, const SurfaceNodes& nodes,
                                          const SearchedSurface& own, const SearchedSurface& other,
                                          double reach) {
  const Box box = box_around(other.surface.x);
  std::vector<FacingPoint> near(nodes.x.size());
  parallel_for(
      exec, near.size(),
      [&](std::size_t n) {
        const Vec3d normal = own.normals[std::size_t(nodes.vertex[n])];
        if (normal != Vec3d{} && squared_distance(box, nodes.x[n]) <= reach * reach)
          near[n] = facing_point(other, nodes.x[n], own, nodes.vertex[n]);
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

/// Shortest edge of the triangles around a vertex [m].
double shortest_edge(const SearchedSurface& surface, int vertex) {
  double shortest = std::numeric_limits<double>::infinity();
  const auto v = std::size_t(vertex);
  for (std::size_t n = surface.around[v]; n < surface.around[v + 1]; n++) {
    const Int3 t = surface.surface.triangles[std::size_t(surface.triangles[n])];
    for (int corner = 0; corner < 3; corner++)
      shortest = std::min(shortest, norm(surface.surface.x[std::size_t(t[corner])] -
                                         surface.surface.x[std::size_t(t[(corner + 1) % 3])]));
  }
  return shortest;
}

/// Removes sites of the second surface that meet a vertex of the first, which has a site itself.
void remove_doubles(const SearchedSurface& first, const SearchedSurface& second, std::size_t first_count,
                    std::vector<PairSite>& sites) {
  constexpr double kWider = 1 + 1e-9;  // window of the search, against rounding
  if (first_count == 0) return;
  // vertices of the first, sorted along the longest side of their box
  struct Vertex {
    Vec3d x;
    double edge = 0;  // shortest [m]
  };
  const double mean = std::min(first.edge, second.edge);
  std::vector<Vec3d> points;
  std::vector<Vertex> vertices;
  for (std::size_t s = 0; s < first_count; s++) {
    points.push_back(position_of(first.surface, sites[s].a));
    vertices.push_back({points.back(), std::min(mean, shortest_edge(first, sites[s].a.vertex.x))});
  }
  const Box box = box_around(points);
  const Vec3d side = box.high - box.low;
  const int axis = side.x >= side.y && side.x >= side.z ? 0 : side.y >= side.z ? 1 : 2;
  std::sort(vertices.begin(), vertices.end(),
            [axis](const Vertex& a, const Vertex& b) { return a.x[axis] < b.x[axis]; });
  // sites of the second near one of them
  const auto is_double = [&](const PairSite& site) {
    const Vec3d x = position_of(first.surface, site.b);
    const double edge = shortest_edge(second, site.a.vertex.x), far = kWider * kSameVertex * mean;
    auto other = std::partition_point(vertices.begin(), vertices.end(),
                                      [&](const Vertex& v) { return v.x[axis] < x[axis] - far; });
    for (; other != vertices.end() && other->x[axis] <= x[axis] + far; ++other)
      if (norm(other->x - x) < kSameVertex * std::min(edge, other->edge)) return true;
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
  const SearchedSurface first = searched_surface(surfaces[0]), second = searched_surface(surfaces[1]);
  // both directions
  std::vector<PairSite> sites;
  add_sites(exec, first, second, params, sites);
  const std::size_t first_count = sites.size();
  add_sites(exec, second, first, params, sites);
  remove_doubles(first, second, first_count, sites);
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
  const SearchedSurface own = searched_surface(surfaces[0]), other = searched_surface(surfaces[1]);
  const std::vector<FacingPoint> near = nearest_of_nodes(exec, nodes, own, other, params.reach);
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
  const SearchedSurface own = searched_surface(surfaces[0]), other = searched_surface(surfaces[1]);
  std::vector<double> heights;
  for (const FacingPoint& near : nearest_of_nodes(exec, nodes, own, other, params.reach + params.deepest))
    heights.push_back(near.faces && near.height >= -params.deepest ? std::min(params.reach, near.height)
                                                                   : params.reach);
  return heights;
}

std::vector<double> rest_heights(const Exec& exec, const PairSurface& of, const PairSurface& above,
                                 double reach, double deepest) {
  const SearchedSurface from = searched_surface(of), to = searched_surface(above);
  std::vector<double> heights(of.x.size(), reach);
  parallel_for(
      exec, from.vertices.size(),
      [&](std::size_t n) {
        const auto v = std::size_t(from.vertices[n]);
        const FacingPoint near = facing_point(to, of.x[v], from, from.vertices[n]);
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
