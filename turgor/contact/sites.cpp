#include "turgor/contact/sites.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::contact {

namespace {

constexpr double kRigid = 1e-9;  // relative to the softest point: stiffer points cannot move

struct Search {
  const DeformedSurface& deformed;
  const SiteSearch& in;
  std::vector<Site>& sites;
  std::size_t first = 0;  // index of this tool's first site in `sites`
  int dropped = 0;
};

bool touched_before(const Search& s, const Site& site) {
  return std::any_of(s.in.last.begin(), s.in.last.end(),
                     [&](const Site& last) { return is_same_site(last, site) && bears_force(last); });
}

bool is_held(const Search& s, const Site& site) {
  for (const Site& held : s.sites) {
    if (held.state != SiteState::kHeld) return false;
    if (share_a_point(s.deformed.patch, held, site)) return true;
  }
  return false;
}

/// True when a site may become a contact. A contact that bore no force requires that the tool faces the
/// surface. Rigid points never touch.
bool can_touch(const Search& s, const Site& site) {
  if (is_held(s, site)) return false;
  double softness = 0;
  visit_points(s.deformed.patch, site,
               [&](std::size_t p, double w) { softness += w * w * s.deformed.rest.softness[p]; });
  if (!(softness > kRigid * s.deformed.rest.largest_softness)) return false;
  return site.touched_before || dot(site.normal, weighted(s.deformed.patch, site, s.deformed.outward)) < 0;
}

/// Order in which sites are dropped when the capacity is exceeded: the farthest first. Sites that bore force
/// come last, because their distance is about zero with either sign.
double eviction_priority(const Site& site) { return site.touched_before ? -HUGE_VAL : site.distance; }

/// Inserts a site. In a full list it replaces this tool's site of highest eviction priority.
void insert(Search& s, Site site) {
  site.touched_before = touched_before(s, site);
  if (!can_touch(s, site)) return;
  // free capacity
  if (s.sites.size() < s.in.capacity) {
    s.sites.push_back(site);
    return;
  }
  // this tool's site of highest eviction priority
  Site* least = nullptr;
  for (std::size_t i = s.first; i < s.sites.size(); i++)
    if (least == nullptr || eviction_priority(s.sites[i]) > eviction_priority(*least)) least = &s.sites[i];
  const double own = eviction_priority(site), worst = least == nullptr ? own : eviction_priority(*least);
  s.dropped += std::max(own, worst) < 0;
  if (own < worst) *least = site;
}

bool is_listed(const Search& s, const Site& site) {
  return std::any_of(s.sites.begin(), s.sites.end(), [&](const Site& other) {
    return is_same_site(site, other) && norm(site.weight - other.weight) < 1e-9;
  });
}

/// Extends the tool outward beyond its equator, seen along the body's normal at rest, by an opening cone as a
/// stylus or a finger has. A linear body would otherwise fold over a ball that is pressed deeper than its
/// radius, and enclose it. The cone's tangent planes have the normals (across, -kOpening).
ShapeDistance continue_outward(const Shape& shape, ShapeDistance found, Vec3d outward) {
  constexpr double kOpening = 0.35;  // sine of the cone's half angle
  const double height = dot(found.normal, outward);
  const Vec3d across = found.normal - height * outward;
  const double width = norm(across);
  if (height <= -kOpening || width <= 0) return found;
  const Vec3d normal = across * (std::sqrt(1 - kOpening * kOpening) / width) - kOpening * outward;
  if (std::holds_alternative<MeshShape>(shape)) return {found.distance, normal};
  const double radius = tip_radius(shape);  // of the nearest ball
  return {(found.distance + radius) * dot(found.normal, normal) - radius, normal};
}

void measure(const Search& s, Site& site) {
  const Vec3d x = weighted(s.deformed.patch, site, s.deformed.x),
              outward = normalized(weighted(s.deformed.patch, site, s.deformed.rest.normal));
  const ShapeDistance found = continue_outward(*s.in.shape, distance(*s.in.shape, s.in.pose, x), outward);
  site.distance = found.distance;
  site.normal = found.normal;
}

void find_points(Search& s) {
  const double near = bounding_radius(*s.in.shape) + s.in.reach;
  for (std::size_t p = 0; p < s.deformed.x.size(); p++) {
    const Vec3d d = s.deformed.x[p] - s.in.pose.position;
    if (dot(d, d) > near * near) continue;
    Site site{.tool = s.in.tool, .point = {int(p), -1, -1}, .weight = {1, 0, 0}};
    measure(s, site);
    if (site.distance <= s.in.reach) insert(s, site);
  }
}

/// Mean gap below a cluster, which the tool must not make negative under even pressure. False when the tool
/// is far away.
bool measure_cluster(const Search& s, double near, Site& site) {
  double distance_sum = 0;
  Vec3d normal;
  bool is_near = false;
  visit_points(s.deformed.patch, site, [&](std::size_t p, double w) {
    const Vec3d x = s.deformed.x[p], d = x - s.in.pose.position;
    is_near |= dot(d, d) <= near * near;
    const ShapeDistance found =
        continue_outward(*s.in.shape, distance(*s.in.shape, s.in.pose, x), s.deformed.rest.normal[p]);
    distance_sum += w * found.distance, normal += w * found.normal;
  });
  site.distance = distance_sum, site.normal = normalized(normal);
  return is_near;
}

void find_clusters(Search& s) {
  const double near = bounding_radius(*s.in.shape) + s.in.reach;
  TURGOR_CHECK(s.in.level >= 1 && std::size_t(s.in.level) <= s.deformed.patch.levels.size(),
               "the level belongs to the patch");
  const std::size_t count = sfem::cluster_count(s.deformed.patch.levels[std::size_t(s.in.level - 1)]);
  for (std::size_t c = 0; c < count; c++) {
    Site site{.tool = s.in.tool, .level = s.in.level, .point = {int(c), -1, -1}, .weight = {1, 0, 0}};
    if (measure_cluster(s, near, site) && site.distance <= s.in.reach) insert(s, site);
  }
}

/// Site at a position in a triangle, carried by the corners of nonzero weight. False for a single corner,
/// because that is a point.
bool make_site(const Int3& corners, Vec3d weights, Site& site) {
  TURGOR_CHECK(!is_finite(weights) || sums_to_one(weights),
               "the weights of a position in a triangle sum to one");
  int count = 0;
  for (int corner = 0; corner < 3; corner++) {
    if (weights[corner] <= 0) continue;
    site.point[count] = corners[corner];
    site.weight[count++] = weights[corner];
  }
  if (count == 2 && site.point.x > site.point.y) {  // an edge has the same key in both of its triangles
    std::swap(site.point.x, site.point.y);
    std::swap(site.weight.x, site.weight.y);
  }
  return count > 1;
}

/// Permitted depth of a tool in a triangle before it bears force. It is large where the corners alone keep
/// the tool out, zero where they do not, and interpolated between. So the force has no jump from one triangle
/// to the next.
double permitted_depth(double longest_edge, double tip_size) {
  constexpr double kFrom = 1, kTo = 1.5, kMaxDepth = 0.25;  // of the tip's radius
  const double edge = longest_edge / tip_size;
  return edge < kFrom ? HUGE_VAL : kMaxDepth * tip_size * std::max(0.0, (kTo - edge) / (kTo - kFrom));
}

/// Weights of a site on the corners of a triangle. False when another point carries it.
bool weights_on(const Site& site, const Int3& corners, Vec3d& weights) {
  weights = {};
  for (int i = 0; i < 3 && site.point[i] >= 0; i++) {
    const int p = site.point[i];
    if (p != corners.x && p != corners.y && p != corners.z) return false;
    weights[p == corners.x ? 0 : p == corners.y ? 1 : 2] = site.weight[i];
  }
  return true;
}

/// Moves a site that bore force gradually towards the nearest position. A triangle that is pressed at one
/// position tilts, so that the nearest position would alternate from tick to tick.
Vec3d follow_nearest(const Search& s, const Int3& corners, Vec3d nearest) {
  constexpr double kFollowFraction = 0.2, kReached = 1e-3;
  // site of the last tick in this triangle
  Vec3d was = nearest, other;
  double least = HUGE_VAL;
  for (const Site& last : s.in.last) {
    const bool bore = last.tool == s.in.tool && last.level == 0 && last.point.y >= 0 && bears_force(last);
    if (!bore || !weights_on(last, corners, other) || norm(other - nearest) >= least) continue;
    least = norm(other - nearest), was = other;
  }
  return norm(nearest - was) < kReached ? nearest : was + kFollowFraction * (nearest - was);
}

/// Contact of a corner of a mesh tool with the inside of a triangle: the plane of contact is that of the
/// triangle. The normal of the tool turns by a large angle around a corner. With it, positions in a triangle
/// that tilts under the tool would alternate from tick to tick, and rounding would decide where the tool
/// ends. Changes nothing where the corner is far from the plane, or behind it.
void touch_face(const Search& s, const Int3& corners, Vec3d tip, Site& site) {
  if (site.point.z < 0) return;
  const auto at = [&](int p) { return s.deformed.x[std::size_t(p)]; };
  const Vec3d outward = normalized(cross(at(corners.y) - at(corners.x), at(corners.z) - at(corners.x)));
  const double height = dot(tip - weighted(s.deformed.patch, site, s.deformed.x), outward);
  if (dot(site.normal, outward) >= 0 || std::abs(height) > 0.5 * tip_radius(*s.in.shape)) return;
  site.normal = -outward, site.distance = height;
}

void find_in_triangle(Search& s, const Int3& corners, double allowed) {
  TURGOR_CHECK(are_indices(corners, s.deformed.x.size()),
               "the corners of a triangle are points of the patch");
  const Vec3d a = s.deformed.x[std::size_t(corners.x)], b = s.deformed.x[std::size_t(corners.y)],
              c = s.deformed.x[std::size_t(corners.z)];
  const bool has_corners = std::holds_alternative<MeshShape>(*s.in.shape);
  for (int i = 0, count = tip_count(*s.in.shape); i < count; i++) {
    const Vec3d from = to_world(s.in.pose, tip(*s.in.shape, i)), nearest = closest_weights(from, a, b, c);
    Site site{.tool = s.in.tool};
    if (!make_site(corners, has_corners ? nearest : follow_nearest(s, corners, nearest), site)) continue;
    measure(s, site);
    if (has_corners) touch_face(s, corners, from, site);
    site.distance += allowed;
    if (site.distance <= s.in.reach && !is_listed(s, site)) insert(s, site);
  }
}

double longest_edge(Vec3d a, Vec3d b, Vec3d c) { return std::max({norm(b - a), norm(c - b), norm(a - c)}); }

/// Longest edge for permitted_depth. It is measured at rest, because a depth that depends on the force's
/// stretch would oscillate. For a triangle that is stretched far, as under a press deeper than the tool's
/// radius, it is nearly the deformed length.
double edge_for_depth(const Search& s, const Int3& corners) {
  constexpr double kDeformedFraction = 0.85;
  const auto rest = [&](int p) { return s.deformed.patch.points[std::size_t(p)].x; };
  const auto now = [&](int p) { return s.deformed.x[std::size_t(p)]; };
  return std::max(longest_edge(rest(corners.x), rest(corners.y), rest(corners.z)),
                  kDeformedFraction * longest_edge(now(corners.x), now(corners.y), now(corners.z)));
}

void find_in_triangles(Search& s) {
  const double tip_size = tip_radius(*s.in.shape), near = bounding_radius(*s.in.shape) + s.in.reach;
  const Vec3d p = s.in.pose.position;
  for (const Int3& corners : s.deformed.patch.triangles) {
    const Vec3d a = s.deformed.x[std::size_t(corners.x)], b = s.deformed.x[std::size_t(corners.y)],
                c = s.deformed.x[std::size_t(corners.z)];
    // skip triangles by their bounding box
    const Vec3d low = min(min(a, b), c), high = max(max(a, b), c), d = p - min(max(p, low), high);
    if (dot(d, d) > near * near) continue;
    const double allowed = permitted_depth(edge_for_depth(s, corners), tip_size);
    if (allowed < tip_size) find_in_triangle(s, corners, allowed);
  }
}

}  // namespace

void measure_surface(const sfem::Patch& patch, PatchSurface& surface) {
  const std::size_t n = patch.points.size();
  TURGOR_CHECK(patch.compliance.size() == 9 * n * n,
               "the compliance has three rows and three columns per point");
  surface.normal.assign(n, {});
  surface.area.assign(n, 0);
  surface.softness.resize(n);
  surface.border.resize(n);
  surface.largest_softness = 0;
  // border points: around an inner point every neighbor follows and precedes another one, so that the
  // differences of their indices cancel
  std::vector<double>& fan = surface.softness;
  std::fill(fan.begin(), fan.end(), 0.0);
  // normals and areas
  for (const Int3& v : patch.triangles) {
    const auto x = [&](int corner) { return patch.points[std::size_t(v[corner])].x; };
    const Vec3d cross_product = cross(x(1) - x(0), x(2) - x(0));
    for (int corner = 0; corner < 3; corner++) {
      const auto p = std::size_t(v[corner]);
      surface.normal[p] += cross_product;
      surface.area[p] += norm(cross_product) / 6;
      fan[p] += v[(corner + 2) % 3] - v[(corner + 1) % 3];
    }
  }
  // normalize; softness from the compliance's diagonal
  for (std::size_t p = 0; p < n; p++) {
    surface.normal[p] = normalized(surface.normal[p]);
    surface.border[p] = fan[p] != 0;
    const double* diagonal = &patch.compliance[9 * n * p + 3 * p];
    surface.softness[p] = (diagonal[0] + diagonal[3 * n + 1] + diagonal[6 * n + 2]) / 3;
    surface.largest_softness = std::max(surface.largest_softness, surface.softness[p]);
  }
}

void find_outward(const sfem::Patch& patch, std::span<const Vec3d> x, std::vector<Vec3d>& outward) {
  TURGOR_CHECK(x.size() == patch.points.size(), "every point of the patch has a position");
  outward.assign(x.size(), {});
  for (const Int3& v : patch.triangles) {
    const auto a = std::size_t(v.x), b = std::size_t(v.y), c = std::size_t(v.z);
    const Vec3d n = cross(x[b] - x[a], x[c] - x[a]);
    outward[a] += n, outward[b] += n, outward[c] += n;
  }
}

int find_sites(const DeformedSurface& deformed, const SiteSearch& search, std::vector<Site>& sites) {
  TURGOR_ASSERT(search.shape != nullptr, "a search for sites has a shape");
  Search s{deformed, search, sites, sites.size()};
  if (search.level > 0) {
    find_clusters(s);
    return s.dropped;
  }
  find_points(s);
  find_in_triangles(s);
  return s.dropped;
}

bool is_inside(const DeformedSurface& deformed, Vec3d x, double reach) {
  TURGOR_CHECK(deformed.outward.size() == deformed.x.size(), "every point has an outward vector");
  double nearest = reach * reach;
  bool inside = false;
  for (const Int3& v : deformed.patch.triangles) {
    const auto a = std::size_t(v.x), b = std::size_t(v.y), c = std::size_t(v.z);
    const Vec3d w = closest_weights(x, deformed.x[a], deformed.x[b], deformed.x[c]);
    const Vec3d d = x - (w.x * deformed.x[a] + w.y * deformed.x[b] + w.z * deformed.x[c]);
    if (dot(d, d) >= nearest) continue;
    nearest = dot(d, d);
    inside = dot(d, w.x * deformed.outward[a] + w.y * deformed.outward[b] + w.z * deformed.outward[c]) < 0;
  }
  return inside;
}

}  // namespace turgor::contact
