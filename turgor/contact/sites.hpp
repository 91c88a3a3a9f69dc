// Contact sites between tools and a patch surface: points of the patch, and positions inside triangles that
// are large compared with the tool. The search uses the surface of the last tick and the present tool poses.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "turgor/contact/coulomb.hpp"
#include "turgor/contact/tool.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/sfem/patch.hpp"

namespace turgor::contact {

/// A contact site: one point of the patch, a position inside a triangle, or a cluster of points under uniform
/// pressure. Clusters replace points when a contact has more points than the solver's capacity.
struct Site {
  int tool = 0;
  int level = 0;           // 0 = points; L > 0 = a cluster of Patch::levels[L − 1]
  Int3 point{-1, -1, -1};  // points of the patch, -1 = unused; at level > 0, x is the cluster's index
  Vec3d weight;            // interpolation weights of `point`, sum 1
  double distance = 0;     // from the tool to the body before the tick, negative inside the tool [m]
  Vec3d normal;            // from the tool toward the body, unit
  Vec3d anchor;  // position on the tool to which the site sticks or is held, in the tool's frame [m]
  Vec3d force;   // on the body [N]
  SiteState state = SiteState::kOpen;
  bool touched_before = false;  // it bore force in the last tick
};

/// Calls visit(point, weight) for the points that carry a site. The weights sum to 1.
template <class Visit>
void visit_points(const sfem::Patch& patch, const Site& site, const Visit& visit) {
  if (site.level > 0) {
    TURGOR_CHECK(is_index(site.level - 1, patch.levels.size()), "the level of a site belongs to the patch");
    const sfem::PatchLevel& level = patch.levels[std::size_t(site.level - 1)];
    const auto c = std::size_t(site.point.x);
    for (auto m = std::size_t(level.first[c]); m < std::size_t(level.first[c + 1]); m++)
      visit(std::size_t(level.points[m]), level.share[m]);
    return;
  }
  for (int corner = 0; corner < 3 && site.point[corner] >= 0; corner++)
    visit(std::size_t(site.point[corner]), site.weight[corner]);
}
inline Vec3d weighted(const sfem::Patch& patch, const Site& site, std::span<const Vec3d> of_points) {
  Vec3d sum;
  visit_points(patch, site, [&](std::size_t p, double w) { sum += w * of_points[p]; });
  return sum;
}
inline bool is_same_site(const Site& a, const Site& b) {
  return a.tool == b.tool && a.level == b.level && a.point == b.point;
}
inline bool share_a_point(const sfem::Patch& patch, const Site& a, const Site& b) {
  bool shared = false;
  visit_points(patch, a, [&](std::size_t p, double) {
    visit_points(patch, b, [&](std::size_t q, double) { shared |= p == q; });
  });
  return shared;
}
inline bool bears_force(const Site& site) { return site.force != Vec3d{}; }

/// Properties of a patch at rest.
struct PatchSurface {
  std::vector<Vec3d> normal;         // outward unit normal of each point
  std::vector<double> area;          // a third of the area of the triangles around each point [m²]
  std::vector<double> softness;      // mean of the diagonal entries of each point's compliance [m/N]
  std::vector<std::uint8_t> border;  // 1: at the edge of the patch
  double largest_softness = 0;       // maximum of `softness` [m/N]
};
/// Computes the properties of a patch. Does not allocate if `surface` has already stored a patch of this
/// size.
void measure_surface(const sfem::Patch& patch, PatchSurface& surface);

/// Outward vector at every point of a deformed surface, not normalized.
void find_outward(const sfem::Patch& patch, std::span<const Vec3d> x, std::vector<Vec3d>& outward);

/// The deformed surface of a patch.
struct DeformedSurface {
  const sfem::Patch& patch;
  const PatchSurface& rest;
  std::span<const Vec3d> x, outward;
};

/// Parameters of a site search.
struct SiteSearch {
  int tool = 0;
  const Shape* shape = nullptr;
  Pose pose;
  double reach = 0;            // sites farther than this from the tool are ignored [m]
  std::span<const Site> last;  // sites of the last tick. A site that bore force stays a candidate even if the
                               // tool no longer faces the surface.
  std::size_t capacity = 0;    // largest size of `sites`; the nearest sites are kept
  int level = 0;               // see Site::level
};

/// Appends the sites of a tool to `sites`, which begins with the held sites. A site that shares a point with
/// a held site is not added. Returns the number of touched sites beyond the capacity. Positions inside
/// triangles are searched at level 0 only, because clusters occur only where the points are dense compared
/// with the tool.
int find_sites(const DeformedSurface& deformed, const SiteSearch& search, std::vector<Site>& sites);

/// True if a position is inside the body, according to the nearest triangle of the patch, and less than
/// `reach` from that triangle.
bool is_inside(const DeformedSurface& deformed, Vec3d x, double reach);

}  // namespace turgor::contact
