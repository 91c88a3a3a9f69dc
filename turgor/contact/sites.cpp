#include "turgor/contact/sites.hpp"

#include <algorithm>
#include <cmath>

namespace turgor::contact {

namespace {

constexpr double kRigid = 1e-9;  // points softer than this part of the softest one can be moved

struct Search {
  const DeformedSurface& lie;
  const SiteSearch& in;
  std::vector<Site>& sites;
  std::size_t first = 0;  // of this tool's in `sites`
  int dropped = 0;
};

bool touched_before(const Search& s, const Site& site) {
  return std::any_of(s.in.last.begin(), s.in.last.end(),
                     [&](const Site& last) { return is_same_place(last, site) && bears_force(last); });
}

bool is_held(const Search& s, const Site& site) {
  for (const Site& held : s.sites) {
    if (held.state != SiteState::kHeld) return false;
    if (share_a_point(s.lie.patch, held, site)) return true;
  }
  return false;
}

/// A contact begins only where the tool faces the surface, and never on what cannot move.
bool can_touch(const Search& s, const Site& site) {
  if (is_held(s, site)) return false;
  double softness = 0;
  visit_points(s.lie.patch, site,
               [&](std::size_t p, double w) { softness += w * w * s.lie.surface.softness[p]; });
  if (!(softness > kRigid * s.lie.surface.largest_softness)) return false;
  return dot(site.normal, weighted(s.lie.patch, site, s.lie.outward)) < 0 || touched_before(s, site);
}

/// Which sites may be left out where there is no room for all: the farthest, and none that bore force, which
/// lies about in the tool's surface, a little within or without.
double eviction_priority(const Search& s, const Site& site) {
  return touched_before(s, site) ? -HUGE_VAL : site.distance;
}

/// Puts a site on the list; when that is full, in the place of this tool's most dispensable one.
void insert(Search& s, const Site& site) {
  if (!can_touch(s, site)) return;
  if (s.sites.size() < s.in.capacity) {
    s.sites.push_back(site);
    return;
  }
  Site* least = nullptr;
  for (std::size_t i = s.first; i < s.sites.size(); i++)
    if (least == nullptr || eviction_priority(s, s.sites[i]) > eviction_priority(s, *least))
      least = &s.sites[i];
  const double here = eviction_priority(s, site),
               there = least == nullptr ? here : eviction_priority(s, *least);
  s.dropped += std::max(here, there) < 0;
  if (here < there) *least = site;
}

bool is_listed(const Search& s, const Site& site) {
  return std::any_of(s.sites.begin(), s.sites.end(), [&](const Site& other) {
    return is_same_place(site, other) && norm(site.weight - other.weight) < 1e-9;
  });
}

/// Near a tool's equator, seen along the body's normal at rest, the tool is continued outward as a cone that
/// opens, as a stylus or a finger does: a linear body would fold over a ball that is pressed deeper than its
/// radius, and swallow it. The cone is that of the tangents with the normals (across, -kOpening).
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
  const Vec3d x = weighted(s.lie.patch, site, s.lie.x),
              outward = normalized(weighted(s.lie.patch, site, s.lie.surface.normal));
  const ShapeDistance found = continue_outward(*s.in.shape, distance(*s.in.shape, s.in.pose, x), outward);
  site.distance = found.distance;
  site.normal = found.normal;
}

void find_points(Search& s) {
  const double near = bounding_radius(*s.in.shape) + s.in.reach;
  for (std::size_t p = 0; p < s.lie.x.size(); p++) {
    const Vec3d d = s.lie.x[p] - s.in.pose.position;
    if (dot(d, d) > near * near) continue;
    Site site{.tool = s.in.tool, .point = {int(p), -1, -1}, .weight = {1, 0, 0}};
    measure(s, site);
    if (site.distance <= s.in.reach) insert(s, site);
  }
}

/// The mean gap below a cluster: with an even pressure on it, what the tool must not make negative. False
/// when the tool is nowhere near.
bool measure_cluster(const Search& s, double near, Site& site) {
  double distance_sum = 0;
  Vec3d normal;
  bool is_near = false;
  visit_points(s.lie.patch, site, [&](std::size_t p, double w) {
    const Vec3d x = s.lie.x[p], d = x - s.in.pose.position;
    is_near |= dot(d, d) <= near * near;
    const ShapeDistance found =
        continue_outward(*s.in.shape, distance(*s.in.shape, s.in.pose, x), s.lie.surface.normal[p]);
    distance_sum += w * found.distance, normal += w * found.normal;
  });
  site.distance = distance_sum, site.normal = normalized(normal);
  return is_near;
}

void find_clusters(Search& s) {
  const double near = bounding_radius(*s.in.shape) + s.in.reach;
  const std::size_t count = sfem::cluster_count(s.lie.patch.levels[std::size_t(s.in.level - 1)]);
  for (std::size_t c = 0; c < count; c++) {
    Site site{.tool = s.in.tool, .level = s.in.level, .point = {int(c), -1, -1}, .weight = {1, 0, 0}};
    if (measure_cluster(s, near, site) && site.distance <= s.in.reach) insert(s, site);
  }
}

/// A place in a triangle, on the corners that carry it; false when that is one corner, which is a point.
bool make_site(const Int3& corners, Vec3d weights, Site& site) {
  int count = 0;
  for (int corner = 0; corner < 3; corner++) {
    if (weights[corner] <= 0) continue;
    site.point[count] = corners[corner];
    site.weight[count++] = weights[corner];
  }
  if (count == 2 && site.point.x > site.point.y) {  // an edge has one name in both of its triangles
    std::swap(site.point.x, site.point.y);
    std::swap(site.weight.x, site.weight.y);
  }
  return count > 1;
}

/// How deep a tool may lie in a triangle before that bears force: much where the corners alone keep it out,
/// nothing where they do not, and in between so that the force has no jump from one triangle to the next.
double allowed_depth(double longest_edge, double tip_size) {
  constexpr double kFrom = 1, kTo = 1.5, kMuch = 0.25;  // of the tip's radius
  const double edge = longest_edge / tip_size;
  return edge < kFrom ? HUGE_VAL : kMuch * tip_size * std::max(0.0, (kTo - edge) / (kTo - kFrom));
}

/// The weights of a site on the corners of a triangle; false when it hangs on another point.
bool weights_on(const Site& site, const Int3& corners, Vec3d& weights) {
  weights = {};
  for (int i = 0; i < 3 && site.point[i] >= 0; i++) {
    const int p = site.point[i];
    if (p != corners.x && p != corners.y && p != corners.z) return false;
    weights[p == corners.x ? 0 : p == corners.y ? 1 : 2] = site.weight[i];
  }
  return true;
}

/// A place that bore force goes towards the nearest one bit by bit: a triangle that is pressed at one place
/// tilts, so that another one is nearest in the next tick, and then the first again.
Vec3d follow_nearest(const Search& s, const Int3& corners, Vec3d nearest) {
  constexpr double kBit = 0.2, kThere = 1e-3;
  Vec3d was = nearest, other;
  double least = HUGE_VAL;
  for (const Site& last : s.in.last) {
    const bool bore = last.tool == s.in.tool && last.level == 0 && last.point.y >= 0 && bears_force(last);
    if (!bore || !weights_on(last, corners, other) || norm(other - nearest) >= least) continue;
    least = norm(other - nearest), was = other;
  }
  return norm(nearest - was) < kThere ? nearest : was + kBit * (nearest - was);
}

void find_in_triangle(Search& s, const Int3& corners, double allowed) {
  const Vec3d a = s.lie.x[std::size_t(corners.x)], b = s.lie.x[std::size_t(corners.y)],
              c = s.lie.x[std::size_t(corners.z)];
  for (int i = 0, count = tip_count(*s.in.shape); i < count; i++) {
    const Vec3d nearest = closest_weights(to_world(s.in.pose, tip(*s.in.shape, i)), a, b, c);
    Site site{.tool = s.in.tool};
    if (!make_site(corners, follow_nearest(s, corners, nearest), site)) continue;
    measure(s, site);
    site.distance += allowed;
    if (site.distance <= s.in.reach && !is_listed(s, site)) insert(s, site);
  }
}

double longest_edge(Vec3d a, Vec3d b, Vec3d c) { return std::max({norm(b - a), norm(c - b), norm(a - c)}); }

/// At rest, so that the depth does not change with what the force stretches, which would make it swing; of a
/// triangle that is stretched far, as under a press deeper than the tool's radius, nearly as it lies now.
double lasting_edge(const Search& s, const Int3& corners) {
  constexpr double kNearly = 0.85;
  const auto rest = [&](int p) { return s.lie.patch.points[std::size_t(p)].x; };
  const auto now = [&](int p) { return s.lie.x[std::size_t(p)]; };
  return std::max(longest_edge(rest(corners.x), rest(corners.y), rest(corners.z)),
                  kNearly * longest_edge(now(corners.x), now(corners.y), now(corners.z)));
}

void find_in_triangles(Search& s) {
  const double tip_size = tip_radius(*s.in.shape), near = bounding_radius(*s.in.shape) + s.in.reach;
  const Vec3d p = s.in.pose.position;
  for (const Int3& corners : s.lie.patch.triangles) {
    const Vec3d a = s.lie.x[std::size_t(corners.x)], b = s.lie.x[std::size_t(corners.y)],
                c = s.lie.x[std::size_t(corners.z)];
    const Vec3d low = min(min(a, b), c), high = max(max(a, b), c), d = p - min(max(p, low), high);
    if (dot(d, d) > near * near) continue;
    const double allowed = allowed_depth(lasting_edge(s, corners), tip_size);
    if (allowed < tip_size) find_in_triangle(s, corners, allowed);
  }
}

}  // namespace

void measure_surface(const sfem::Patch& patch, PatchSurface& surface) {
  const std::size_t n = patch.points.size();
  surface.normal.assign(n, {});
  surface.area.assign(n, 0);
  surface.softness.resize(n);
  surface.border.resize(n);
  surface.largest_softness = 0;
  // Around an inner point every neighbour follows and precedes another one, so that their numbers cancel.
  std::vector<double>& fan = surface.softness;
  std::fill(fan.begin(), fan.end(), 0.0);
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
  for (std::size_t p = 0; p < n; p++) {
    surface.normal[p] = normalized(surface.normal[p]);
    surface.border[p] = fan[p] != 0;
    const double* diagonal = &patch.compliance[9 * n * p + 3 * p];
    surface.softness[p] = (diagonal[0] + diagonal[3 * n + 1] + diagonal[6 * n + 2]) / 3;
    surface.largest_softness = std::max(surface.largest_softness, surface.softness[p]);
  }
}

void find_outward(const sfem::Patch& patch, std::span<const Vec3d> x, std::vector<Vec3d>& outward) {
  outward.assign(x.size(), {});
  for (const Int3& v : patch.triangles) {
    const auto a = std::size_t(v.x), b = std::size_t(v.y), c = std::size_t(v.z);
    const Vec3d n = cross(x[b] - x[a], x[c] - x[a]);
    outward[a] += n, outward[b] += n, outward[c] += n;
  }
}

int find_sites(const DeformedSurface& lie, const SiteSearch& search, std::vector<Site>& sites) {
  Search s{lie, search, sites, sites.size()};
  if (search.level > 0) {
    find_clusters(s);
    return s.dropped;
  }
  find_points(s);
  find_in_triangles(s);
  return s.dropped;
}

bool is_inside(const DeformedSurface& lie, Vec3d place, double reach) {
  double nearest = reach * reach;
  bool inside = false;
  for (const Int3& v : lie.patch.triangles) {
    const auto a = std::size_t(v.x), b = std::size_t(v.y), c = std::size_t(v.z);
    const Vec3d w = closest_weights(place, lie.x[a], lie.x[b], lie.x[c]);
    const Vec3d d = place - (w.x * lie.x[a] + w.y * lie.x[b] + w.z * lie.x[c]);
    if (dot(d, d) >= nearest) continue;
    nearest = dot(d, d);
    inside = dot(d, w.x * lie.outward[a] + w.y * lie.outward[b] + w.z * lie.outward[c]) < 0;
  }
  return inside;
}

}  // namespace turgor::contact
