#include "turgor/contact/touch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

constexpr double kStep = 0.5;    // of the tip's radius: the farthest that a tool moves in one solution
constexpr int kMostSteps = 8;    // in a tick; a tool that moves farther has jumped
constexpr int kLetGoSteps = 3;   // what was held springs back far: the tools are looked at again on its way
constexpr double kReach = 0.01;  // of the tip's radius: sites that near are looked at beforehand

/// The parts of one tick that all functions need.
struct Tick {
  const sfem::Patch& patch;
  TouchState& state;
  std::span<const Tool> tools;
  std::span<const ToolPose> poses;  // of the end of the tick
  std::span<ToolForce> forces;
  ViscousTick viscous;
  double part = 1;  // of the way from the last tick's poses

  Pose pose(std::size_t tool) const;
  Lie lie() const { return {patch, state.surface, state.x, state.outward}; }
};

Vec3d lerp(Vec3d a, Vec3d b, double t) { return a + t * (b - a); }

/// Axes that are between two orthonormal ones, orthonormal again.
Mat3d between(const Mat3d& a, const Mat3d& b, double t) {
  const Vec3d x = normalized(lerp(a.column[0], b.column[0], t)), y = lerp(a.column[1], b.column[1], t);
  const Vec3d z = normalized(cross(x, y));
  return norm(z) > 0.5 && norm(x) > 0.5 ? Mat3d{{x, cross(z, x), z}} : b;
}

Pose Tick::pose(std::size_t tool) const {
  const Pose &from = state.tools[tool].pose, &to = poses[tool].pose;
  if (part >= 1 || !state.tools[tool].seen) return to;
  return {lerp(from.position, to.position, part), between(from.axes, to.axes, part)};
}

/// No point of the tool moves farther than this from one pose to the other [m].
double motion(const Shape& shape, const Pose& from, const Pose& to) {
  double turn = 0;
  for (int axis = 0; axis < 3; axis++) turn += norm(to.axes.column[axis] - from.axes.column[axis]);
  return norm(to.position - from.position) + turn * bounding_radius(shape);
}

/// Forgets what a tool did: it was taken away, or moved so fast that nobody knows along which path.
void forget_tool(TouchState& state, int tool) {
  const auto end = std::remove_if(state.sites.begin(), state.sites.end(),
                                  [tool](const Site& site) { return site.tool == tool; });
  state.sites.erase(end, state.sites.end());
  state.held = int(std::count_if(state.sites.begin(), state.sites.end(),
                                 [](const Site& site) { return site.state == SiteState::kHeld; }));
  ToolMemory& memory = state.tools[std::size_t(tool)];
  memory.seen = memory.touching = memory.inside = false;
}

/// Looks at the poses; returns how many steps this tick takes.
int look_at_poses(Tick& tick) {
  const bool lets_go = std::any_of(tick.state.sites.begin(), tick.state.sites.end(), [&](const Site& site) {
    return site.state == SiteState::kHeld && !tick.poses[std::size_t(site.tool)].hold;
  });
  int steps = lets_go ? kLetGoSteps : 1;
  for (std::size_t i = 0; i < tick.tools.size(); i++) {
    ToolMemory& memory = tick.state.tools[i];
    const Shape& shape = tick.tools[i].shape;
    const Pose& pose = tick.poses[i].pose;
    tick.forces[i] = {};
    tick.forces[i].invalid_pose = !is_valid(pose);
    if (tick.forces[i].invalid_pose) {
      forget_tool(tick.state, int(i));
      continue;
    }
    const double parts = memory.seen ? motion(shape, memory.pose, pose) / (kStep * tip_radius(shape)) : 0;
    if (parts > kMostSteps) forget_tool(tick.state, int(i));
    if (memory.seen) {
      steps = std::max(steps, int(std::ceil(parts)));
      continue;
    }
    memory.inside = is_inside(tick.lie(), pose.position, bounding_radius(shape));
  }
  return steps;
}

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
    const bool taken =
        std::any_of(held.begin(), held.end(), [&](const Site& other) { return share_a_point(other, site); });
    if (holds_already || taken) continue;
    held.push_back(site);
    held.back().state = SiteState::kHeld;
    held.back().anchor = to_tool(state.tools[tool].pose, weighted(site, state.x));
  }
  state.held = int(held.size());
}

/// A site takes its force over from the last tick, and where it sticks.
void continue_site(const Tick& tick, const Pose& pose, Site& site) {
  const TouchState& state = tick.state;
  const ToolMemory& memory = state.tools[std::size_t(site.tool)];
  const Vec3d x = weighted(site, state.x);
  const auto last = std::find_if(state.sites.begin(), state.sites.end(),
                                 [&](const Site& other) { return is_same_place(other, site); });
  site.anchor = memory.touching ? to_tool(memory.pose, x) : to_tool(pose, x);
  if (last == state.sites.end() || !bears_force(*last)) return;
  site.force = last->force;
  // In a triangle the place may be another one now; what it was off its anchor stays.
  site.anchor = last->anchor + to_tool(memory.pose, x) - to_tool(memory.pose, weighted(*last, state.x));
}

void find_all_sites(Tick& tick) {
  TouchState& state = tick.state;
  hold_sites(tick);
  for (std::size_t i = 0; i < tick.tools.size(); i++) {
    if (tick.forces[i].invalid_pose) continue;
    ToolMemory& memory = state.tools[i];
    const Shape& shape = tick.tools[i].shape;
    const Pose pose = tick.pose(i);
    const double moved = memory.seen ? motion(shape, memory.pose, pose) : 0;
    const std::size_t before = state.new_sites.size();
    const SiteSearch search{.tool = int(i),
                            .shape = &shape,
                            .pose = pose,
                            .reach = moved + kReach * tip_radius(shape),
                            .last = state.sites,
                            .capacity = std::size_t(state.params.capacity)};
    tick.forces[i].dropped = find_sites(tick.lie(), search, state.new_sites);
    if (!memory.inside) continue;
    // What appeared inside of the body touches nothing until it has come out.
    memory.inside = is_inside(tick.lie(), pose.position, bounding_radius(shape)) ||
                    std::any_of(state.new_sites.begin() + std::ptrdiff_t(before), state.new_sites.end(),
                                [](const Site& site) { return site.distance < 0; });
    state.new_sites.resize(before);
  }
  for (std::size_t s = std::size_t(state.held); s < state.new_sites.size(); s++) {
    Site& site = state.new_sites[s];
    continue_site(tick, tick.pose(std::size_t(site.tool)), site);
  }
}

/// One block of C = Eᵀ Ξ E.
void add_block(const sfem::Patch& patch, const Site& row, const Site& column, double scale, double* out,
               std::size_t stride) {
  const std::size_t n = 3 * patch.points.size();
  visit_points(column, [&](std::size_t q, double wq) {
    visit_points(row, [&](std::size_t p, double wp) {
      const double* block = &patch.compliance[3 * q * n + 3 * p];
      for (std::size_t j = 0; j < 3; j++)
        for (std::size_t i = 0; i < 3; i++) out[j * stride + i] += scale * wp * wq * block[j * n + i];
    });
  });
}

/// The lower triangle.
void fill_compliance(Tick& tick) {
  Coulomb& problem = tick.state.problem;
  const std::vector<Site>& sites = tick.state.new_sites;
  const auto stride = std::size_t(problem.stride);
  const double scale = 1 / (1 + tick.viscous.p);
  // Two tools that squeeze one place, or many sites in one triangle, would have no finite answer, or many.
  const double own = tick.state.params.tool_softness * scale * tick.state.surface.largest_softness;
  for (std::size_t j = 0; j < sites.size(); j++) {
    double* column = &problem.compliance[3 * j * stride];
    for (std::size_t axis = 0; axis < 3; axis++)
      std::fill_n(column + axis * stride + 3 * j, 3 * (sites.size() - j), 0.0);
    for (std::size_t i = j; i < sites.size(); i++)
      add_block(tick.patch, sites[i], sites[j], scale, column + 3 * i, stride);
    if (sites[j].state == SiteState::kHeld) continue;
    for (std::size_t axis = 0; axis < 3; axis++) column[axis * stride + 3 * j + axis] += own;
  }
}

/// Where a point would be without any force of this tick.
Vec3d free_place(const Tick& tick, std::size_t point) {
  const Vec3d x = tick.patch.points[point].x + tick.state.offset[point];
  if (tick.viscous.p == 0) return x;
  return x + tick.viscous.p / (1 + tick.viscous.p) * tick.state.history.v[point];
}

/// The separation of a site from its tool if no force acted: along the normal, the gap to the tool's tangent
/// plane at its nearest place; across it, the slip since it stuck last.
Vec3d free_separation(const Tick& tick, const Site& site) {
  Vec3d x;
  visit_points(site, [&](std::size_t p, double w) { x += w * free_place(tick, p); });
  const Vec3d slip = x - to_world(tick.pose(std::size_t(site.tool)), site.anchor);
  if (site.state == SiteState::kHeld) return slip;
  const Vec3d now = weighted(site, tick.state.x), n = site.normal;
  return slip - dot(slip, n) * n + (site.distance + dot(n, x - now)) * n;
}

void solve_sites(Tick& tick) {
  TouchState& state = tick.state;
  Coulomb& problem = state.problem;
  std::vector<Site>& sites = state.new_sites;
  problem.count = int(sites.size());
  problem.held = state.held;
  fill_compliance(tick);
  for (std::size_t s = 0; s < sites.size(); s++) {
    const Vec3d b = free_separation(tick, sites[s]), f = sites[s].force;
    for (int axis = 0; axis < 3; axis++) {
      problem.separation[3 * s + std::size_t(axis)] = b[axis];
      problem.force[3 * s + std::size_t(axis)] = f[axis];
    }
    problem.normal[s] = sites[s].normal;
    problem.friction[s] = tick.tools[std::size_t(sites[s].tool)].friction;
  }
  state.solution = solve(problem, state.params.solver);
  for (std::size_t s = 0; s < sites.size(); s++) {
    sites[s].force = {problem.force[3 * s], problem.force[3 * s + 1], problem.force[3 * s + 2]};
    sites[s].state = problem.state[s];
  }
}

/// The site sticks where it is now, unless it stuck already.
void move_anchors(Tick& tick) {
  TouchState& state = tick.state;
  for (ToolMemory& memory : state.tools) memory.touching = false;
  for (Site& site : state.sites) {
    const auto tool = std::size_t(site.tool);
    if (bears_force(site)) state.tools[tool].touching = true;
    if (site.state == SiteState::kSlip) site.anchor = to_tool(tick.pose(tool), weighted(site, state.x));
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

double largest_penetration(const Tick& tick, std::size_t tool) {
  const Shape& shape = tick.tools[tool].shape;
  const Pose& pose = tick.poses[tool].pose;
  const double near = bounding_radius(shape);
  double largest = 0;
  for (const Vec3d x : tick.state.x) {
    const Vec3d d = x - pose.position;
    if (dot(d, d) < near * near) largest = std::max(largest, -distance(shape, pose, x).distance);
  }
  return largest;
}

void sum_forces(const Tick& tick) {
  const TouchState& state = tick.state;
  for (const Site& site : state.sites) {
    if (!bears_force(site)) continue;
    const auto tool = std::size_t(site.tool);
    ToolForce& out = tick.forces[tool];
    out.force -= site.force;
    out.torque -= cross(weighted(site, state.x) - tick.poses[tool].pose.position, site.force);
    out.contacts++;
    out.sliding += site.state == SiteState::kSlip;
    visit_points(site, [&](std::size_t p, double w) {
      out.area += w * state.surface.area[p];
      out.beyond_patch |= state.surface.border[p] != 0;
    });
  }
  for (std::size_t i = 0; i < tick.tools.size(); i++) {
    tick.forces[i].inside = state.tools[i].inside;
    if (!tick.forces[i].invalid_pose && !state.tools[i].inside)
      tick.forces[i].largest_penetration = largest_penetration(tick, i);
  }
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
  if (params.viscosity.stiffening > 0) state.history.v = state.history.phi = state.u;
  state.tools.resize(tool_count);
  state.rests.resize(tool_count);
  const Vec3d nowhere = Vec3d{1, 1, 1} * std::numeric_limits<double>::quiet_NaN();
  state.poses.assign(tool_count, {{nowhere, {}}, false});
  state.forces.resize(tool_count);
  state.match.forces.resize(tool_count);
  state.problem = make_coulomb(params.capacity);
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
  state.force.assign(n, {});
  for (const Site& site : state.sites)
    visit_points(site, [&](std::size_t p, double w) { state.force[p] += w * site.force; });
  const double p = viscous.p, scale = 1 / (1 + p);
  state.u.assign(n, {});
  if (p > 0)
    for (std::size_t i = 0; i < n; i++) state.u[i] = p * scale * state.history.v[i];
  double* u = &state.u.data()->x;
  for (std::size_t point = 0; point < n; point++) {
    if (state.force[point] == Vec3d{}) continue;
    const Vec3d f = scale * state.force[point];
    const double* a = &patch.compliance[9 * n * point];
    const double *b = a + 3 * n, *c = b + 3 * n;
    TURGOR_LANES
    for (std::size_t i = 0; i < 3 * n; i++) u[i] += a[i] * f.x + b[i] * f.y + c[i] * f.z;
  }
  state.x.resize(n);
  for (std::size_t i = 0; i < n; i++) state.x[i] = patch.points[i].x + state.offset[i] + state.u[i];
  find_outward(patch, state.x, state.outward);
}

void contact_pressure(const TouchState& state, std::span<double> pressure) {
  TURGOR_ASSERT(pressure.size() == state.x.size(), "one pressure a point");
  for (std::size_t i = 0; i < pressure.size(); i++) {
    const double area = state.surface.area[i];
    pressure[i] = area > 0 ? -dot(state.force[i], state.surface.normal[i]) / area : 0;
  }
}

}  // namespace turgor::contact
