// Where tools touch a surface: points of the patch, and places inside of triangles that are large against the
// tool. Sites are found on the surface as it lies after the last tick, with distances and normals of the
// tools as they lie now.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "turgor/contact/coulomb.hpp"
#include "turgor/contact/tool.hpp"
#include "turgor/models/sfem/patch.hpp"

namespace turgor::contact {

/// A place on the surface that a tool touches or may touch: one point of the patch, somewhere in a triangle,
/// or, where there would be too many of those, a cluster of points that are pressed on evenly.
struct Site {
  int tool = 0;
  int level = 0;           // 0 = points; else a cluster of Patch::levels[level − 1]
  Int3 point{-1, -1, -1};  // of the patch; -1 = not used; x is the cluster's number
  Vec3d weight;            // of each, sum 1
  double distance = 0;     // from the tool before the tick [m]
  Vec3d normal;            // from the tool at the body, unit
  Vec3d anchor;            // where it sticks to the tool or is held, in the tool's frame [m]
  Vec3d force;             // on the body [N]
  SiteState state = SiteState::kOpen;
};

/// Calls visit(point, weight) for the points that a site hangs on; the weights' sum is 1.
template <class Visit>
void visit_points(const sfem::Patch& patch, const Site& site, const Visit& visit) {
  if (site.level > 0) {
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
inline bool is_same_place(const Site& a, const Site& b) {
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

/// What follows from a patch alone.
struct PatchSurface {
  std::vector<Vec3d> normal;         // of each point at rest, unit, outward
  std::vector<double> area;          // a third of the triangles around it [m²]
  std::vector<double> softness;      // mean of the compliance's diagonal there [m/N]
  std::vector<std::uint8_t> border;  // 1: at the edge of the patch
  double largest_softness = 0;       // [m/N]
};
/// Allocates nothing when `surface` has held a patch as large.
void measure_surface(const sfem::Patch& patch, PatchSurface& surface);

/// Outward at every point of a surface that is deformed, of any length.
void find_outward(const sfem::Patch& patch, std::span<const Vec3d> x, std::vector<Vec3d>& outward);

/// A surface as it lies.
struct DeformedSurface {
  const sfem::Patch& patch;
  const PatchSurface& surface;
  std::span<const Vec3d> x, outward;
};

/// What is looked for.
struct SiteSearch {
  int tool = 0;
  const Shape* shape = nullptr;
  Pose pose;
  double reach = 0;            // sites farther from the tool are of no interest [m]
  std::span<const Site> last;  // of the last tick: what touched then may touch on the far side of the tool
  std::size_t capacity = 0;    // of the list; the nearest sites are kept
  int level = 0;               // how coarse: see Site::level
};

/// Appends the sites of a tool to `sites`, which begins with those that are held: nothing else can press on
/// their points. Returns how many touched ones found no room. Places within triangles are looked for at level
/// 0 alone: where clusters are needed, corners are close enough to keep a tool out.
int find_sites(const DeformedSurface& lie, const SiteSearch& search, std::vector<Site>& sites);

/// Does a place lie within the body, as far as the nearest triangle of the patch tells, and nearer to it than
/// `reach`?
bool is_inside(const DeformedSurface& lie, Vec3d place, double reach);

}  // namespace turgor::contact
