#include "turgor/contact/patch_follow.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

ContactMiddle middle_of_contacts(const sfem::Patch& patch, const TouchState& state, int tool) {
  double sum = 0;
  Vec3d middle;
  for (const Site& site : state.sites) {
    if (site.tool != tool || !bears_force(site)) continue;
    const double force = norm(site.force);
    sum += force;
    visit_points(patch, site, [&](std::size_t p, double w) { middle += force * w * patch.points[p].x; });
  }
  return sum > 0 ? ContactMiddle{middle / sum, true} : ContactMiddle{};
}

/// The nearest place of the coarse surface at rest.
Vec3d nearest_on_surface(const sfem::Model& model, Vec3d x) {
  const std::vector<Vec3d>& vertices = model.body.mesh.vertices;
  Vec3d nearest;
  double best = HUGE_VAL;
  for (const Int3& t : model.surface.triangles) {
    const Vec3d a = vertices[std::size_t(t.x)], b = vertices[std::size_t(t.y)],
                c = vertices[std::size_t(t.z)];
    const Vec3d low = min(min(a, b), c), high = max(max(a, b), c), apart = x - min(max(x, low), high);
    if (dot(apart, apart) >= best) continue;
    const Vec3d w = closest_weights(x, a, b, c), place = w.x * a + w.y * b + w.z * c;
    const double squared = dot(x - place, x - place);
    if (squared < best) best = squared, nearest = place;
  }
  return nearest;
}

void sort_by_key(const sfem::Patch& patch, std::vector<int>& order) {
  order.resize(patch.points.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return patch.points[std::size_t(a)].key < patch.points[std::size_t(b)].key;
  });
}

/// Finds the points that are in both patches, walking through both in the order of keys; returns how many.
int match_points(const sfem::Patch& from, const sfem::Patch& to, PatchMatch& match) {
  sort_by_key(from, match.from_order);
  sort_by_key(to, match.to_order);
  match.new_point.assign(from.points.size(), -1);
  match.old_point.assign(to.points.size(), -1);
  int count = 0;
  for (std::size_t i = 0, j = 0; i < match.from_order.size() && j < match.to_order.size();) {
    const auto a = std::size_t(match.from_order[i]), b = std::size_t(match.to_order[j]);
    const std::uint64_t key_a = from.points[a].key, key_b = to.points[b].key;
    if (key_a == key_b) match.new_point[a] = int(b), match.old_point[b] = int(a), count++;
    i += key_a <= key_b, j += key_b <= key_a;
  }
  return count;
}

int nearest_point(const sfem::Patch& patch, Vec3d x) {
  int nearest = 0;
  double best = HUGE_VAL;
  for (std::size_t i = 0; i < patch.points.size(); i++) {
    const Vec3d d = patch.points[i].x - x;
    if (dot(d, d) < best) best = dot(d, d), nearest = int(i);
  }
  return nearest;
}

Vec3d rest_place(const sfem::Patch& patch, const Site& site) {
  Vec3d rest;
  visit_points(patch, site, [&](std::size_t p, double w) { rest += w * patch.points[p].x; });
  return rest;
}

/// To the nearest point of the new patch, or to the cluster that it is in.
void move_to_nearest(const sfem::Patch& from, const sfem::Patch& to, const Mat3d& tool_axes, Site& site) {
  const Vec3d rest = rest_place(from, site);
  site.level = std::min(site.level, int(to.levels.size()));
  const int nearest = nearest_point(to, rest);
  const bool alone = site.level == 0;
  site.point = {alone ? nearest : to.levels[std::size_t(site.level - 1)].cluster[std::size_t(nearest)], -1,
                -1};
  site.weight = {1, 0, 0};
  site.anchor += transposed(tool_axes) * (rest_place(to, site) - rest);
}

/// A site of the old patch on the new one: on the same points when they are all there, or on the nearest one.
/// Two sites that end on the same point become one with the sum of their forces.
void move_site(const sfem::Patch& from, const sfem::Patch& to, TouchState& state, Site site) {
  Int3 point = site.point;
  bool kept = site.level == 0;
  for (int corner = 0; kept && corner < 3 && site.point[corner] >= 0; corner++) {
    point[corner] = state.match.new_point[std::size_t(site.point[corner])];
    kept = point[corner] >= 0;
  }
  if (kept)
    site.point = point;
  else
    move_to_nearest(from, to, state.tools[std::size_t(site.tool)].pose.axes, site);
  for (Site& other : state.new_sites)
    if (is_same_place(other, site)) {
      other.force += site.force;
      return;
    }
  state.new_sites.push_back(site);
}

/// What the material remembers: at points that are in both patches as it was, elsewhere as the forces on the
/// coarse body tell.
void move_history(const HandedHistory& handed, TouchState& state) {
  ViscousHistory& h = state.history;
  if (h.v.empty()) return;
  TURGOR_ASSERT(handed.v.size() == state.match.old_point.size(), "a viscous material hands over its history");
  h.far.assign(handed.far.begin(), handed.far.end());
  h.far_fraction = 1;
  std::vector<Vec3d>& next = state.match.history;
  next.assign(handed.v.begin(), handed.v.end());
  for (std::size_t i = 0; i < next.size(); i++)
    if (const int old = state.match.old_point[i]; old >= 0) next[i] = h.v[std::size_t(old)];
  std::swap(h.v, next);
  h.phi.assign(h.v.size(), {});
}

void move_offset(TouchState& state) {
  std::vector<Vec3d>& next = state.match.offset;
  next.assign(state.match.old_point.size(), {});
  for (std::size_t i = 0; i < next.size(); i++)
    if (const int old = state.match.old_point[i]; old >= 0) next[i] = state.offset[std::size_t(old)];
  std::swap(state.offset, next);
}

/// Sites stick to their tools where the same forces on the new patch put them; what is held and still there
/// stays where it is held.
void move_sites(const sfem::Patch& from, const sfem::Patch& to, const ViscousTick& viscous,
                TouchState& state) {
  state.new_sites.clear();
  for (const Site& site : state.sites) move_site(from, to, state, site);
  std::swap(state.sites, state.new_sites);
  move_points(to, viscous, state);
  state.held = 0;
  for (Site& site : state.sites) {
    state.held += site.state == SiteState::kHeld;
    if (site.state == SiteState::kHeld) continue;
    site.anchor = to_tool(state.tools[std::size_t(site.tool)].pose, weighted(to, site, state.x));
  }
}

}  // namespace

void find_middles(const sfem::Patch& patch, const TouchState& state, std::span<ContactMiddle> middles) {
  for (std::size_t t = 0; t < middles.size(); t++) middles[t] = middle_of_contacts(patch, state, int(t));
}

std::vector<Vec3d> touched_places(const sfem::Model& model, std::span<const ContactMiddle> middles,
                                  std::span<const ToolPose> poses, std::span<const Vec3d> before) {
  std::vector<Vec3d> places;
  for (std::size_t i = 0; i < poses.size(); i++) {
    Vec3d place = i < before.size() ? before[i] : model.body.mesh.vertices[0];
    if (is_valid(poses[i].pose))
      place = middles[i].touches ? middles[i].place : nearest_on_surface(model, poses[i].pose.position);
    places.push_back(place);
  }
  return places;
}

bool must_follow(const FollowParams& params, std::span<const Vec3d> centers, std::span<const Vec3d> places) {
  if (centers.size() != places.size()) return true;
  for (std::size_t i = 0; i < places.size(); i++)
    if (norm(places[i] - centers[i]) > params.hysteresis * params.radius) return true;
  return false;
}

HandedHistory handed_history(const sfem::Model& model, const ViscousHistory& history, const sfem::Patch& from,
                             const sfem::Patch& to) {
  if (history.v.empty()) return {};
  HandedHistory handed{.v = {}, .far = coarse_history(history, from)};
  handed.v = displacements(model, handed.far, to);
  return handed;
}

Handover take_patch(TouchState& state, const sfem::Patch& from, const sfem::Patch& to,
                    std::span<const Tool> tools, const HandedHistory& history) {
  TURGOR_ASSERT(state.x.size() == from.points.size(), "the state of a touch belongs to its patch");
  Handover handover;
  handover.kept_points = match_points(from, to, state.match);
  for (std::size_t t = 0; t < tools.size(); t++) {
    state.match.forces[t] = state.forces[t];
    state.rests[t].force += state.forces[t].force;
    state.rests[t].torque += state.forces[t].torque;
  }
  measure_surface(to, state.surface);
  move_history(history, state);
  move_offset(state);
  move_sites(from, to, viscous_tick(state.params.viscosity, 0), state);
  constexpr int kLooks = 2;  // at the tools, as the new surface lies
  for (int i = 0; i < kLooks; i++) touch(to, state, tools, state.poses, 0, state.forces);
  for (std::size_t t = 0; t < tools.size(); t++) {
    const ToolForce& now = state.forces[t];
    ForceRest& rest = state.rests[t];
    const ToolForce& before = state.match.forces[t];
    handover.force_jump = std::max(handover.force_jump, norm(now.force - before.force));
    handover.torque_jump = std::max(handover.torque_jump, norm(now.torque - before.torque));
    rest.force -= now.force;
    rest.torque -= now.torque;
    rest.reference = norm(now.force);
  }
  return handover;
}

void blend(const FollowParams& params, TouchState& state, double dt, std::span<ToolForce> forces) {
  for (std::size_t t = 0; t < forces.size(); t++) {
    ForceRest& rest = state.rests[t];
    const double length = norm(rest.force), haptic = norm(forces[t].force);
    if (forces[t].invalid_pose || forces[t].inside) rest = {};
    double kept = std::exp(-dt / params.blend_time);
    if (length * (1 - kept) > params.largest_step) kept = 1 - params.largest_step / length;
    rest.force *= kept;
    rest.torque *= kept;
    const double share = haptic < rest.reference ? haptic / rest.reference : 1;
    forces[t].force += share * rest.force;
    forces[t].torque += share * rest.torque;
  }
}

}  // namespace turgor::contact
