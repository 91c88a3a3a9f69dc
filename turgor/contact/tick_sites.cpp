#include <algorithm>

#include "turgor/contact/touch_tick.hpp"
#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

constexpr double kReach =
    0.01;  // of the tip radius: distance within which sites are included before they touch

/// Collects the held sites: those of the last tick while their tool holds, and the touched ones of a tool
/// that starts to hold. No point is held twice.
void hold_sites(Tick& tick) {
  TouchState& state = tick.state;
  std::vector<Site>& held = state.new_sites;
  held.clear();
  // sites held before: keep or release
  for (Site& site : state.sites) {
    if (site.state != SiteState::kHeld) continue;
    if (tick.poses[std::size_t(site.tool)].hold)
      held.push_back(site);
    else
      site.state = SiteState::kOpen;
  }
  // sites that become held
  const std::size_t before = held.size();
  for (const Site& site : state.sites) {
    const auto tool = std::size_t(site.tool);
    if (site.state == SiteState::kHeld || !tick.poses[tool].hold || !bears_force(site)) continue;
    const bool holds_already = std::any_of(held.begin(), held.begin() + std::ptrdiff_t(before),
                                           [&](const Site& other) { return other.tool == site.tool; });
    const bool is_in_use = std::any_of(
        held.begin(), held.end(), [&](const Site& other) { return share_a_point(tick.patch, other, site); });
    if (holds_already || is_in_use) continue;
    held.push_back(site);
    held.back().state = SiteState::kHeld;
    held.back().anchor = to_tool(state.tools[tool].pose, weighted(tick.patch, site, state.x));
  }
  state.held = int(held.size());
}

/// Nearest site of the last tick on the same points; null if none.
const Site* last_site(const TouchState& state, const Site& site) {
  const Site* nearest = nullptr;
  for (const Site& last : state.sites)
    if (is_same_site(last, site) &&
        (nearest == nullptr || norm(last.weight - site.weight) < norm(nearest->weight - site.weight)))
      nearest = &last;
  return nearest;
}

/// Initializes a site with the force and the anchor of the last tick.
void continue_site(const Tick& tick, const Pose& pose, Site& site) {
  const TouchState& state = tick.state;
  const ToolMemory& memory = state.tools[std::size_t(site.tool)];
  const Vec3d x = weighted(tick.patch, site, state.x);
  const Site* last = last_site(state, site);
  site.anchor = memory.touching ? to_tool(memory.pose, x) : to_tool(pose, x);
  if (last == nullptr || !bears_force(*last)) return;
  site.force = last->force;
  // In a triangle the position may have changed; its offset from the anchor is kept.
  site.anchor =
      last->anchor + to_tool(memory.pose, x) - to_tool(memory.pose, weighted(tick.patch, *last, state.x));
}

/// Finds the sites of a tool at the finest level within its capacity. The level becomes coarser as soon as
/// touched sites are dropped. It becomes finer only with ample capacity, so that one more point does not make
/// it alternate.
void find_at_level(Tick& tick, SiteSearch search) {
  constexpr double kSpareRatio =
      2.5;  // spare capacity required; the next finer level has about twice as many sites
  const int coarsest = int(tick.patch.levels.size());
  std::vector<Site>& sites = tick.state.new_sites;
  const std::size_t before = sites.size();
  int dropped = 0;
  // coarsen until nothing is dropped
  for (search.level = std::min(search.level, coarsest);; search.level++) {
    dropped = find_sites(tick.deformed(), search, sites);
    if (dropped == 0 || search.level == coarsest) break;
    sites.resize(before);
  }
  // finer level in the next tick
  TURGOR_CHECK(sites.size() <= search.capacity, "contact sites stay within their capacity");
  const bool finer =
      search.level > 0 && kSpareRatio * double(sites.size() - before) < double(search.capacity - before);
  const auto tool = std::size_t(search.tool);
  tick.state.tools[tool].level = search.level - (finer ? 1 : 0);
  tick.forces[tool].dropped = dropped;
  tick.forces[tool].level = search.level;
}

}  // namespace

void find_sites_of_all_tools(Tick& tick) {
  TouchState& state = tick.state;
  hold_sites(tick);
  // sites of each tool within its share of the capacity
  for (std::size_t i = 0; i < tick.tools.size(); i++) {
    if (tick.forces[i].invalid_pose || tick.tools[i].needle) continue;
    ToolMemory& memory = state.tools[i];
    const Shape& shape = tick.tools[i].shape;
    const Pose pose = tick.pose(i);
    if (memory.inside) {  // appeared inside: no contact until it has left the body
      memory.inside = is_inside(tick.deformed(), tool_position(shape, pose), bounding_radius(shape)) ||
                      largest_penetration(tick, i, pose) > 0;
      continue;
    }
    const double moved = memory.seen ? motion(shape, memory.pose, pose) : 0;
    TURGOR_CHECK(state.new_sites.size() <= std::size_t(state.params.capacity),
                 "contact sites stay within their capacity");
    const std::size_t share =
        (std::size_t(state.params.capacity) - state.new_sites.size()) / (tick.tools.size() - i);
    find_at_level(tick, {.tool = int(i),
                         .shape = &shape,
                         .pose = pose,
                         .reach = moved + kReach * tip_radius(shape),
                         .last = state.sites,
                         .capacity = state.new_sites.size() + share,
                         .level = memory.level});
  }
  // warm start
  for (std::size_t s = std::size_t(state.held); s < state.new_sites.size(); s++) {
    Site& site = state.new_sites[s];
    continue_site(tick, tick.pose(std::size_t(site.tool)), site);
  }
}

}  // namespace turgor::contact
