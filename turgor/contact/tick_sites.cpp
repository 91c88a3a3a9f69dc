#include <algorithm>

#include "turgor/contact/tick.hpp"

namespace turgor::contact {

namespace {

constexpr double kReach = 0.01;  // of the tip's radius: sites that near are looked at beforehand

/// Held sites first: those of the last tick as long as their tool holds, and what it touches when it begins.
/// No point is held twice.
void hold_sites(Tick& tick) {
  TouchState& state = tick.state;
  std::vector<Site>& held = state.new_sites;
  held.clear();
  for (Site& site : state.sites) {
    if (site.state != SiteState::kHeld) continue;
    if (tick.poses[std::size_t(site.tool)].hold)
      held.push_back(site);
    else
      site.state = SiteState::kOpen;
  }
  const std::size_t before = held.size();
  for (const Site& site : state.sites) {
    const auto tool = std::size_t(site.tool);
    if (site.state == SiteState::kHeld || !tick.poses[tool].hold || !bears_force(site)) continue;
    const bool holds_already = std::any_of(held.begin(), held.begin() + std::ptrdiff_t(before),
                                           [&](const Site& other) { return other.tool == site.tool; });
    const bool taken = std::any_of(held.begin(), held.end(),
                                   [&](const Site& other) { return share_a_point(tick.patch, other, site); });
    if (holds_already || taken) continue;
    held.push_back(site);
    held.back().state = SiteState::kHeld;
    held.back().anchor = to_tool(state.tools[tool].pose, weighted(tick.patch, site, state.x));
  }
  state.held = int(held.size());
}

/// The site of the last tick that was the nearest to this one on the same points. Null: there was none.
const Site* last_site(const TouchState& state, const Site& site) {
  const Site* nearest = nullptr;
  for (const Site& last : state.sites)
    if (is_same_place(last, site) &&
        (nearest == nullptr || norm(last.weight - site.weight) < norm(nearest->weight - site.weight)))
      nearest = &last;
  return nearest;
}

/// A site takes its force over from the last tick, and where it sticks.
void continue_site(const Tick& tick, const Pose& pose, Site& site) {
  const TouchState& state = tick.state;
  const ToolMemory& memory = state.tools[std::size_t(site.tool)];
  const Vec3d x = weighted(tick.patch, site, state.x);
  const Site* last = last_site(state, site);
  site.anchor = memory.touching ? to_tool(memory.pose, x) : to_tool(pose, x);
  if (last == nullptr || !bears_force(*last)) return;
  site.force = last->force;
  // In a triangle the place may be another one now; what it was off its anchor stays.
  site.anchor =
      last->anchor + to_tool(memory.pose, x) - to_tool(memory.pose, weighted(tick.patch, *last, state.x));
}

/// As finely as there is room. Coarser at once when touched sites found none, finer again only when there is
/// plenty, so that one more point does not make the tool change to and fro.
void find_at_level(Tick& tick, SiteSearch search) {
  constexpr double kPlenty = 2.5;  // times as many sites have room; the next finer level has about twice
  const int coarsest = int(tick.patch.levels.size());
  std::vector<Site>& sites = tick.state.new_sites;
  const std::size_t before = sites.size();
  int dropped = 0;
  for (search.level = std::min(search.level, coarsest);; search.level++) {
    dropped = find_sites(tick.lie(), search, sites);
    if (dropped == 0 || search.level == coarsest) break;
    sites.resize(before);
  }
  const bool finer =
      search.level > 0 && kPlenty * double(sites.size() - before) < double(search.capacity - before);
  const auto tool = std::size_t(search.tool);
  tick.state.tools[tool].level = search.level - (finer ? 1 : 0);
  tick.forces[tool].dropped = dropped;
  tick.forces[tool].level = search.level;
}

}  // namespace

void find_all_sites(Tick& tick) {
  TouchState& state = tick.state;
  hold_sites(tick);
  for (std::size_t i = 0; i < tick.tools.size(); i++) {
    if (tick.forces[i].invalid_pose) continue;
    ToolMemory& memory = state.tools[i];
    const Shape& shape = tick.tools[i].shape;
    const Pose pose = tick.pose(i);
    if (memory.inside) {  // it appeared there; it touches nothing until it has come out
      memory.inside = is_inside(tick.lie(), pose.position, bounding_radius(shape)) ||
                      largest_penetration(tick, i, pose) > 0;
      continue;
    }
    const double moved = memory.seen ? motion(shape, memory.pose, pose) : 0;
    const std::size_t room =
        (std::size_t(state.params.capacity) - state.new_sites.size()) / (tick.tools.size() - i);
    find_at_level(tick, {.tool = int(i),
                         .shape = &shape,
                         .pose = pose,
                         .reach = moved + kReach * tip_radius(shape),
                         .last = state.sites,
                         .capacity = state.new_sites.size() + room,
                         .level = memory.level});
  }
  for (std::size_t s = std::size_t(state.held); s < state.new_sites.size(); s++) {
    Site& site = state.new_sites[s];
    continue_site(tick, tick.pose(std::size_t(site.tool)), site);
  }
}

}  // namespace turgor::contact
