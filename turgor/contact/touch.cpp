#include "turgor/contact/touch.hpp"

#include <algorithm>
#include <limits>

#include "turgor/contact/tick.hpp"
#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

/// The site sticks where it is now, unless it stuck already.
void move_anchors(Tick& tick) {
  TouchState& state = tick.state;
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

void step(Tick& tick, double dt) {
  tick.viscous = viscous_tick(tick.state.params.viscosity, dt);
  find_all_sites(tick);
  solve_sites(tick);
  std::swap(tick.state.sites, tick.state.new_sites);
  move_points(tick.patch, tick.viscous, tick.state);
  if (!tick.state.history.v.empty())
    remember(tick.viscous, tick.state.u, tick.state.force, tick.state.history);
  move_anchors(tick);
  remember_poses(tick);
}

void sum_forces(const Tick& tick) {
  const TouchState& state = tick.state;
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
  for (std::size_t i = 0; i < tick.tools.size(); i++) {
    tick.forces[i].inside = state.tools[i].inside;
    if (!tick.forces[i].invalid_pose && !state.tools[i].inside)
      tick.forces[i].largest_penetration = largest_penetration(tick, i, tick.poses[i].pose);
  }
}

/// u += A f, of three columns one behind the other.
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
  TURGOR_ASSERT(params.capacity > 0, "a touch has room for at least one site");
  const std::size_t n = patch.points.size(), room = std::max(n, largest_patch);
  TouchState state;
  state.params = params;
  for (auto* points : {&state.x, &state.u, &state.outward, &state.force, &state.offset, &state.surface.normal,
                       &state.match.offset})
    points->reserve(room);
  for (auto* numbers : {&state.surface.area, &state.surface.softness}) numbers->reserve(room);
  for (auto* points :
       {&state.match.from_order, &state.match.to_order, &state.match.new_point, &state.match.old_point})
    points->reserve(room);
  state.surface.border.reserve(room);
  measure_surface(patch, state.surface);
  state.offset.assign(n, {});
  move_points(patch, {}, state);
  if (params.viscosity.stiffening > 0) {
    for (auto* points : {&state.history.v, &state.history.phi, &state.match.history}) points->reserve(room);
    state.history.v.assign(n, {});
    state.history.phi.assign(n, {});
  }
  state.tools.resize(tool_count);
  state.rests.resize(tool_count);
  const Vec3d nowhere = Vec3d{1, 1, 1} * std::numeric_limits<double>::quiet_NaN();
  state.poses.assign(tool_count, {{nowhere, {}}, false});
  state.forces.resize(tool_count);
  state.match.forces.resize(tool_count);
  state.problem = make_frictional_contact_problem(params.capacity);
  state.sites.reserve(std::size_t(params.capacity));
  state.new_sites.reserve(std::size_t(params.capacity));
  return state;
}

void touch(const sfem::Patch& patch, TouchState& state, std::span<const Tool> tools,
           std::span<const ToolPose> poses, double dt, std::span<ToolForce> forces) {
  TURGOR_ASSERT(state.x.size() == patch.points.size(), "the state of a touch belongs to its patch");
  TURGOR_ASSERT(
      tools.size() == state.tools.size() && poses.size() == tools.size() && forces.size() == tools.size(),
      "one pose and one force a tool");
  Tick tick{patch, state, tools, poses, forces, {}, 1};
  const int steps = look_at_poses(tick);
  for (int i = 1; i <= steps; i++) {
    tick.part = 1.0 / (steps - i + 1);  // of what is left of the way
    step(tick, dt / steps);
  }
  sum_forces(tick);
  for (std::size_t t = 0; t < tools.size(); t++) state.poses[t] = poses[t], state.forces[t] = forces[t];
}

// u = (Ξ f + p' v)/(1 + p')
void move_points(const sfem::Patch& patch, const ViscousTick& viscous, TouchState& state) {
  const std::size_t n = patch.points.size();
  const double p = viscous.p, scale = 1 / (1 + p);
  const auto add_forces = [&](bool clusters) {
    for (const Site& site : state.sites)
      if ((site.level > 0) == clusters)
        visit_points(patch, site, [&](std::size_t i, double w) { state.force[i] += w * site.force; });
  };
  state.force.assign(n, {});
  add_forces(false);
  state.u.assign(n, {});
  if (p > 0)
    for (std::size_t i = 0; i < n; i++) state.u[i] = p * scale * state.history.v[i];
  for (std::size_t point = 0; point < n; point++)
    if (!(state.force[point] == Vec3d{}))
      add_columns(&patch.compliance[9 * n * point], scale * state.force[point], state.u);
  for (const Site& site : state.sites)
    if (site.level > 0 && bears_force(site)) {
      const sfem::PatchLevel& level = patch.levels[std::size_t(site.level - 1)];
      add_columns(&level.motion[9 * n * std::size_t(site.point.x)], scale * site.force, state.u);
    }
  add_forces(true);
  state.x.resize(n);
  for (std::size_t i = 0; i < n; i++) state.x[i] = patch.points[i].x + state.offset[i] + state.u[i];
  find_outward(patch, state.x, state.outward);
}

void contact_pressure(const PatchSurface& surface, std::span<const Vec3d> force, std::span<double> pressure) {
  TURGOR_ASSERT(pressure.size() == force.size(), "one pressure a point");
  for (std::size_t i = 0; i < pressure.size(); i++) {
    const double area = surface.area[i];
    pressure[i] = area > 0 ? -dot(force[i], surface.normal[i]) / area : 0;
  }
}

}  // namespace turgor::contact
