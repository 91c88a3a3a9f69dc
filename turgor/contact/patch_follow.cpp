#include "turgor/contact/patch_follow.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::contact {

namespace {

ContactCenter contact_center(const sfem::Patch& patch, const TouchState& state, int tool) {
  double sum = 0;
  Vec3d center;
  for (const Site& site : state.sites) {
    if (site.tool != tool || !bears_force(site)) continue;
    const double force = norm(site.force);
    sum += force;
    visit_points(patch, site, [&](std::size_t p, double w) { center += force * w * patch.points[p].x; });
  }
  return sum > 0 ? ContactCenter{center / sum, true} : ContactCenter{};
}

/// Nearest point of the coarse surface at rest.
Vec3d nearest_on_surface(const sfem::Model& model, Vec3d x) {
  const std::vector<Vec3d>& vertices = model.body.mesh.vertices;
  TURGOR_CHECK(!model.surface.triangles.empty(), "a body has a surface");
  Vec3d nearest;
  double best = HUGE_VAL;
  for (const Int3& t : model.surface.triangles) {
    const Vec3d a = vertices[std::size_t(t.x)], b = vertices[std::size_t(t.y)],
                c = vertices[std::size_t(t.z)];
    // skip triangles by their bounding box
    const Vec3d low = min(min(a, b), c), high = max(max(a, b), c), apart = x - min(max(x, low), high);
    if (dot(apart, apart) >= best) continue;
    const Vec3d w = closest_weights(x, a, b, c), closest = w.x * a + w.y * b + w.z * c;
    const double squared = dot(x - closest, x - closest);
    if (squared < best) best = squared, nearest = closest;
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

/// Finds the points that are in both patches by merging their key-sorted lists. Returns their number.
int match_points(const sfem::Patch& from, const sfem::Patch& to, PatchMatch& match) {
  // sort both lists by key
  sort_by_key(from, match.from_order);
  sort_by_key(to, match.to_order);
  TURGOR_CHECK(from.points.size() == match.from_order.size() &&
                   is_sorted_unique(match.to_order, [&](int i) { return to.points[std::size_t(i)].key; }),
               "points of a patch have distinct keys");
  // no match so far
  match.new_point.assign(from.points.size(), -1);
  match.old_point.assign(to.points.size(), -1);
  // merge the sorted lists
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

Vec3d rest_position(const sfem::Patch& patch, const Site& site) {
  Vec3d rest;
  visit_points(patch, site, [&](std::size_t p, double w) { rest += w * patch.points[p].x; });
  return rest;
}

/// Moves a site to the nearest point of the new patch, or to the cluster of that point.
void move_to_nearest(const sfem::Patch& from, const sfem::Patch& to, const Mat3d& tool_axes, Site& site) {
  TURGOR_CHECK(!to.points.empty(), "a patch has points");
  const Vec3d rest = rest_position(from, site);
  site.level = std::min(site.level, int(to.levels.size()));
  const int nearest = nearest_point(to, rest);
  const bool is_point = site.level == 0;
  site.point = {is_point ? nearest : to.levels[std::size_t(site.level - 1)].cluster[std::size_t(nearest)], -1,
                -1};
  site.weight = {1, 0, 0};
  site.anchor += transposed(tool_axes) * (rest_position(to, site) - rest);
}

/// Moves a site to the new patch: to the same points if all of them exist, otherwise to the nearest one.
/// Sites that end on the same point are merged and their forces summed.
void move_site(const sfem::Patch& from, const sfem::Patch& to, TouchState& state, Site site) {
  // map the points of the site
  TURGOR_CHECK(is_index(site.tool, state.tools.size()), "a contact site refers to a tool of the touch");
  Int3 point = site.point;
  bool is_mapped = site.level == 0;
  for (int corner = 0; is_mapped && corner < 3 && site.point[corner] >= 0; corner++) {
    point[corner] = state.match.new_point[std::size_t(site.point[corner])];
    is_mapped = point[corner] >= 0;
  }
  // same points, or the nearest one
  if (is_mapped)
    site.point = point;
  else
    move_to_nearest(from, to, state.tools[std::size_t(site.tool)].pose.axes, site);
  // merge with an equal site
  for (Site& other : state.new_sites)
    if (is_same_site(other, site)) {
      other.force += site.force;
      return;
    }
  state.new_sites.push_back(site);
}

/// Transfers the viscous memory: unchanged at shared points, elsewhere from the forces on the coarse body. A
/// pair that came into use after the patch was offered has none there.
void move_history(const TransferredHistory& transferred, TouchState& state) {
  ViscousHistory& h = state.history;
  if (h.count == 0) return;
  h.far_factor = ViscousHistory::kNoDecay;
  std::vector<Vec3d>& next = state.match.history;
  for (PairHistory& pair : h.pairs) pair.far.clear();
  for (std::size_t k = 0; k < std::size_t(h.count); k++) {
    PairHistory& pair = h.pairs[k];
    next.assign(state.match.old_point.size(), {});
    if (k < transferred.pairs.size()) {
      const TransferredHistory::Pair& from = transferred.pairs[k];
      TURGOR_ASSERT(from.v.size() == next.size(), "a memory of every point");
      pair.far.assign(from.far.begin(), from.far.end());
      std::copy(from.v.begin(), from.v.end(), next.begin());
    }
    for (std::size_t i = 0; i < next.size(); i++)
      if (const int old = state.match.old_point[i]; old >= 0) next[i] = pair.v[std::size_t(old)];
    std::swap(pair.v, next);
    pair.phi.assign(pair.v.size(), {});
  }
}

/// True when the other patch has the same points and clusters: the same patch, linearized elsewhere.
bool is_same_surface(const sfem::Patch& from, const sfem::Patch& to, const PatchMatch& match) {
  if (from.points.size() != to.points.size() || from.levels.size() != to.levels.size()) return false;
  for (std::size_t i = 0; i < match.new_point.size(); i++)
    if (match.new_point[i] != int(i)) return false;
  for (std::size_t l = 0; l < from.levels.size(); l++)
    if (from.levels[l].cluster != to.levels[l].cluster) return false;
  return true;
}

/// A patch with a shift has no other offset (free motions are added in every tick).
void move_offset(const sfem::Patch& to, TouchState& state) {
  TURGOR_CHECK(state.offset.size() == state.match.new_point.size(),
               "every point of the old patch has an offset");
  std::vector<Vec3d>& next = state.match.offset;
  next.assign(state.match.old_point.size(), {});
  for (std::size_t i = 0; i < next.size(); i++)
    if (const int old = state.match.old_point[i]; old >= 0) next[i] = state.offset[std::size_t(old)];
  if (!to.shift.empty()) next.assign(to.shift.begin(), to.shift.end());
  std::swap(state.offset, next);
}

/// Transfers the sites and their anchors. Other sites stick to their tools at the positions that the same
/// forces give on the new patch. A held site keeps its anchor.
void move_sites(const sfem::Patch& from, const sfem::Patch& to, const ViscousTick& viscous,
                TouchState& state) {
  if (is_same_surface(from, to, state.match)) return move_points(to, viscous, state);
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

void find_contact_centers(const sfem::Patch& patch, const TouchState& state,
                          std::span<ContactCenter> contact_centers) {
  for (std::size_t t = 0; t < contact_centers.size(); t++)
    contact_centers[t] = contact_center(patch, state, int(t));
}

std::vector<Vec3d> touched_positions(const sfem::Model& model, std::span<const ContactCenter> contact_centers,
                                     std::span<const ToolPose> poses, std::span<const Vec3d> before) {
  std::vector<Vec3d> positions;
  for (std::size_t i = 0; i < poses.size(); i++) {
    Vec3d closest = i < before.size() ? before[i] : model.body.mesh.vertices[0];
    if (is_valid(poses[i].pose))
      closest = contact_centers[i].touches ? contact_centers[i].position
                                           : nearest_on_surface(model, poses[i].pose.position);
    positions.push_back(closest);
  }
  return positions;
}

bool must_follow(const FollowParams& params, std::span<const Vec3d> centers,
                 std::span<const Vec3d> positions) {
  if (centers.size() != positions.size()) return true;
  for (std::size_t i = 0; i < positions.size(); i++)
    if (norm(positions[i] - centers[i]) > params.hysteresis * params.radius) return true;
  return false;
}

TransferredHistory transferred_history(const sfem::Model& model, const ViscousHistory& history,
                                       const sfem::Patch& from, const sfem::Patch& to) {
  TransferredHistory transferred;
  for (int pair = 0; pair < history.count; pair++) {
    std::vector<VertexForce> far = coarse_history(history, pair, from);
    std::vector<Vec3d> v = displacements(model, far, to);
    transferred.pairs.push_back({.v = std::move(v), .far = std::move(far)});
  }
  return transferred;
}

Handover take_patch(TouchState& state, const sfem::Patch& from, const sfem::Patch& to,
                    std::span<const Tool> tools, const TransferredHistory& history) {
  TURGOR_ASSERT(state.x.size() == from.points.size(), "the state of a touch belongs to its patch");
  // remember forces and jumps on the old patch
  Handover handover;
  handover.shared_points = match_points(from, to, state.match);
  for (std::size_t t = 0; t < tools.size(); t++) {
    state.match.forces[t] = state.forces[t];
    state.remaining_jumps[t].force += state.forces[t].force;
    state.remaining_jumps[t].torque += state.forces[t].torque;
  }
  // transfer the state
  measure_surface(to, state.surface);
  move_history(history, state);
  move_offset(to, state);
  move_sites(from, to, viscous_tick(state.params.viscosity, 0), state);
  constexpr int kRefinements = 2;  // of the contact sites on the new surface
  for (int i = 0; i < kRefinements; i++) solve_touch_tick(to, state, tools, state.poses, 0, state.forces);
  // jump of the forces
  for (std::size_t t = 0; t < tools.size(); t++) {
    const ToolForce& now = state.forces[t];
    RemainingJump& jump = state.remaining_jumps[t];
    const ToolForce& before = state.match.forces[t];
    handover.force_jump = std::max(handover.force_jump, norm(now.force - before.force));
    handover.torque_jump = std::max(handover.torque_jump, norm(now.torque - before.torque));
    jump.force -= now.force;
    jump.torque -= now.torque;
    jump.reference = norm(now.force);
  }
  return handover;
}

void blend(const FollowParams& params, TouchState& state, double dt, std::span<ToolForce> forces) {
  TURGOR_CHECK(forces.size() == state.remaining_jumps.size(), "every tool has a force jump to blend");
  TURGOR_CHECK(params.blend_time > 0 && dt >= 0, "a force jump decays in a positive time");
  for (std::size_t t = 0; t < forces.size(); t++) {
    RemainingJump& jump = state.remaining_jumps[t];
    // decay of the jump, limited by the largest step
    const double length = norm(jump.force), present = norm(forces[t].force);
    if (forces[t].invalid_pose || forces[t].inside) jump = {};
    double decay = std::exp(-dt / params.blend_time);
    if (length * (1 - decay) > params.largest_step) decay = 1 - params.largest_step / length;
    jump.force *= decay;
    jump.torque *= decay;
    // less of the jump while the force is below the reference
    const double fraction = present < jump.reference ? present / jump.reference : 1;
    forces[t].force += fraction * jump.force;
    forces[t].torque += fraction * jump.torque;
  }
}

}  // namespace turgor::contact
