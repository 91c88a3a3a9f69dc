#include "turgor/contact/touch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "turgor/contact/touch_tick.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::contact {

namespace {

/// Moves the anchors of sliding sites to their present positions. A sticking site keeps its anchor.
void move_anchors(Tick& tick) {
  TouchState& state = tick.state;
  TURGOR_CHECK(std::all_of(tick.state.sites.begin(), tick.state.sites.end(),
                           [&](const Site& s) { return is_index(s.tool, tick.tools.size()); }),
               "contact sites refer to tools of the touch");
  for (ToolMemory& memory : state.tools) memory.touching = false;
  for (Site& site : state.sites) {
    const auto tool = std::size_t(site.tool);
    if (bears_force(site)) state.tools[tool].touching = true;
    if (site.state == SiteState::kSlip)
      site.anchor = to_tool(tick.pose(tool), weighted(tick.patch, site, state.x));
  }
}

void remember_poses(Tick& tick) {
  for (std::size_t t = 0; t < tick.tools.size(); t++) {
    if (tick.forces[t].invalid_pose) continue;
    tick.state.tools[t].pose = tick.pose(t);
    tick.state.tools[t].seen = true;
  }
}

void solve_substep(Tick& tick, double dt) {
  // sites and forces
  tick.viscous = viscous_tick(tick.state.params.viscosity, dt);
  find_sites_of_all_tools(tick);
  solve_sites(tick);
  std::swap(tick.state.sites, tick.state.new_sites);
  // displacements and viscous memory
  move_points(tick.patch, tick.viscous, tick.state);
  if (tick.viscous.count > 0) remember(tick.viscous, tick.state.u, tick.state.force, tick.state.history);
  // friction's memory and poses
  move_anchors(tick);
  remember_poses(tick);
}

void sum_forces(const Tick& tick) {
  const TouchState& state = tick.state;
  // forces, torques and areas of contact
  for (const Site& site : state.sites) {
    if (!bears_force(site)) continue;
    const auto tool = std::size_t(site.tool);
    ToolForce& out = tick.forces[tool];
    out.force -= site.force;
    out.torque -= cross(weighted(tick.patch, site, state.x) - tick.poses[tool].pose.position, site.force);
    out.contacts++;
    out.sliding += site.state == SiteState::kSlip;
    visit_points(tick.patch, site, [&](std::size_t p, double w) {
      out.area += (site.level > 0 ? 1 : w) * state.surface.area[p];
      out.beyond_patch |= state.surface.border[p] != 0;
    });
  }
  // penetration
  for (std::size_t i = 0; i < tick.tools.size(); i++) {
    tick.forces[i].inside = state.tools[i].inside;
    if (!tick.forces[i].invalid_pose && !state.tools[i].inside && !tick.tools[i].needle)
      tick.forces[i].largest_penetration = largest_penetration(tick, i, tick.poses[i].pose);
  }
}

/// u += A f for three consecutive columns of A.
void add_columns(const double* a, Vec3d f, std::vector<Vec3d>& of_points) {
  const std::size_t rows = 3 * of_points.size();
  const double *b = a + rows, *c = b + rows;
  double* u = &of_points.data()->x;
  TURGOR_LANES
  for (std::size_t i = 0; i < rows; i++) u[i] += a[i] * f.x + b[i] * f.y + c[i] * f.z;
}

}  // namespace

TouchState make_touch_state(const sfem::Patch& patch, std::size_t tool_count, const TouchParams& params,
                            std::size_t largest_patch) {
  TURGOR_ASSERT(params.capacity > 0, "the capacity of a touch is at least one site");
  const std::size_t n = patch.points.size(), max_points = std::max(n, largest_patch);
  TouchState state;
  // reserve storage for the largest patch
  state.params = params;
  for (auto* points : {&state.x, &state.u, &state.outward, &state.force, &state.offset, &state.surface.normal,
                       &state.match.offset})
    points->reserve(max_points);
  for (auto* numbers : {&state.surface.area, &state.surface.softness}) numbers->reserve(max_points);
  for (auto* points :
       {&state.match.from_order, &state.match.to_order, &state.match.new_point, &state.match.old_point})
    points->reserve(max_points);
  state.surface.border.reserve(max_points);
  // patch at rest
  measure_surface(patch, state.surface);
  state.offset.assign(n, {});
  if (!patch.shift.empty()) state.offset = patch.shift;
  move_points(patch, {}, state);
  // viscous memory
  state.history.count = pair_count(params.viscosity);
  if (state.history.count > 0) state.match.history.reserve(max_points);
  for (std::size_t i = 0; i < std::size_t(state.history.count); i++) {
    PairHistory& pair = state.history.pairs[i];
    for (auto* points : {&pair.v, &pair.phi}) points->reserve(max_points), points->assign(n, {});
  }
  // tools
  state.tools.resize(tool_count);
  state.remaining_jumps.resize(tool_count);
  const Vec3d no_position = Vec3d{1, 1, 1} * std::numeric_limits<double>::quiet_NaN();
  state.poses.assign(tool_count, {{no_position, {}}, false});
  state.forces.resize(tool_count);
  state.match.forces.resize(tool_count);
  // contact problem
  state.problem = make_frictional_contact_problem(params.capacity);
  state.sites.reserve(std::size_t(params.capacity));
  state.new_sites.reserve(std::size_t(params.capacity));
  return state;
}

void solve_touch_tick(const sfem::Patch& patch, TouchState& state, std::span<const Tool> tools,
                      std::span<const ToolPose> poses, double dt, std::span<ToolForce> forces) {
  TURGOR_ASSERT(state.x.size() == patch.points.size(), "the state of a touch belongs to its patch");
  TURGOR_ASSERT(
      tools.size() == state.tools.size() && poses.size() == tools.size() && forces.size() == tools.size(),
      "one pose and one force a tool");
  // substeps of a fast tool
  TURGOR_ASSERT(dt >= 0 && std::isfinite(dt), "a tick has a length that is not negative");
  Tick tick{patch, state, tools, poses, forces, {}, 1};
  const int steps = prepare_poses(tick);
  for (int i = 1; i <= steps; i++) {
    tick.fraction = 1.0 / (steps - i + 1);  // of the remaining motion
    solve_substep(tick, dt / steps);
  }
  // forces on the tools
  sum_forces(tick);
  for (std::size_t t = 0; t < tools.size(); t++) state.poses[t] = poses[t], state.forces[t] = forces[t];
}

// u = (Ξ f + Σ pᵢ' vᵢ)/(1 + P), with f the forces of sites on points and Ξ the patch's compliance
void move_points(const sfem::Patch& patch, const ViscousTick& viscous, TouchState& state) {
  const std::size_t n = patch.points.size();
  TURGOR_CHECK(state.offset.size() == n, "every point of the patch has an offset");
  const double scale = 1 / (1 + viscous.total);
  const auto add_forces = [&](bool clusters) {
    for (const Site& site : state.sites)
      if ((site.level > 0) == clusters)
        visit_points(patch, site, [&](std::size_t i, double w) { state.force[i] += w * site.force; });
  };
  // forces of point sites
  state.force.assign(n, {});
  add_forces(false);
  // viscous component
  state.u.assign(n, {});
  if (viscous.count > 0)
    for (std::size_t i = 0; i < n; i++) state.u[i] = remembered_displacement(viscous, state.history, i);
  // Ξ f of points, then of clusters
  for (std::size_t point = 0; point < n; point++)
    if (!(state.force[point] == Vec3d{}))
      add_columns(&patch.compliance[9 * n * point], scale * state.force[point], state.u);
  for (const Site& site : state.sites)
    if (site.level > 0 && bears_force(site)) {
      const sfem::PatchLevel& level = patch.levels[std::size_t(site.level - 1)];
      add_columns(&level.motion[9 * n * std::size_t(site.point.x)], scale * site.force, state.u);
    }
  // forces of clusters; positions
  add_forces(true);
  state.x.resize(n);
  for (std::size_t i = 0; i < n; i++) state.x[i] = patch.points[i].x + state.offset[i] + state.u[i];
  find_outward(patch, state.x, state.outward);
}

void contact_pressure(const PatchSurface& surface, std::span<const Vec3d> force, std::span<double> pressure) {
  TURGOR_ASSERT(pressure.size() == force.size(), "one pressure a point");
  TURGOR_CHECK(surface.area.size() == force.size() && surface.normal.size() == force.size(),
               "every point has an area and a normal");
  for (std::size_t i = 0; i < pressure.size(); i++) {
    const double area = surface.area[i];
    pressure[i] = area > 0 ? -dot(force[i], surface.normal[i]) / area : 0;
  }
}

}  // namespace turgor::contact
