#include <algorithm>
#include <cmath>

#include "turgor/contact/touch_tick.hpp"
#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

constexpr double kMaxMotion = 0.5;  // of the tip radius: largest motion of a tool in one substep
constexpr int kMaxSubsteps = 8;     // a tick; a tool that moves farther has jumped
constexpr int kReleaseSubsteps =
    3;  // held tissue springs back far when released: contacts are searched on its path

Vec3d lerp(Vec3d a, Vec3d b, double t) { return a + t * (b - a); }

/// Orthonormal axes between two orthonormal ones.
Mat3d interpolate_axes(const Mat3d& a, const Mat3d& b, double t) {
  TURGOR_CHECK(t >= 0 && t <= 1, "an interpolation stays between its ends");
  const Vec3d x = normalized(lerp(a.column[0], b.column[0], t)), y = lerp(a.column[1], b.column[1], t);
  const Vec3d z = normalized(cross(x, y));
  return norm(z) > 0.5 && norm(x) > 0.5 ? Mat3d{{x, cross(z, x), z}} : b;
}

/// Discards the contacts of a tool that was removed or that jumped.
void forget_tool(TouchState& state, int tool) {
  const auto end = std::remove_if(state.sites.begin(), state.sites.end(),
                                  [tool](const Site& site) { return site.tool == tool; });
  state.sites.erase(end, state.sites.end());
  state.held = int(std::count_if(state.sites.begin(), state.sites.end(),
                                 [](const Site& site) { return site.state == SiteState::kHeld; }));
  ToolMemory& memory = state.tools[std::size_t(tool)];
  memory.seen = memory.touching = memory.inside = false;
}

}  // namespace

Pose Tick::pose(std::size_t tool) const {
  const Pose &from = state.tools[tool].pose, &to = poses[tool].pose;
  if (fraction >= 1 || !state.tools[tool].seen) return to;
  return {lerp(from.position, to.position, fraction), interpolate_axes(from.axes, to.axes, fraction)};
}

double motion(const Shape& shape, const Pose& from, const Pose& to) {
  double turn = 0;
  for (int axis = 0; axis < 3; axis++) turn += norm(to.axes.column[axis] - from.axes.column[axis]);
  return norm(to.position - from.position) + turn * bounding_radius(shape);
}

double largest_penetration(const Tick& tick, std::size_t tool, const Pose& pose) {
  const Shape& shape = tick.tools[tool].shape;
  const double near = bounding_radius(shape);
  double largest = 0;
  for (const Vec3d x : tick.state.x) {
    const Vec3d d = x - pose.position;
    if (dot(d, d) < near * near) largest = std::max(largest, -distance(shape, pose, x).distance);
  }
  return largest;
}

int prepare_poses(Tick& tick) {
  // released tissue needs several substeps
  const bool releases = std::any_of(tick.state.sites.begin(), tick.state.sites.end(), [&](const Site& site) {
    return site.state == SiteState::kHeld && !tick.poses[std::size_t(site.tool)].hold;
  });
  int substep_count = releases ? kReleaseSubsteps : 1;
  for (std::size_t i = 0; i < tick.tools.size(); i++) {
    ToolMemory& memory = tick.state.tools[i];
    const Shape& shape = tick.tools[i].shape;
    const Pose& pose = tick.poses[i].pose;
    // invalid pose: no contact
    tick.forces[i] = {};
    tick.forces[i].invalid_pose = !is_valid(pose);
    if (tick.forces[i].invalid_pose) {
      forget_tool(tick.state, int(i));
      continue;
    }
    if (tick.tools[i].needle) continue;
    // substeps by the tool's motion; a jump discards its contacts
    const double substeps =
        memory.seen ? motion(shape, memory.pose, pose) / (kMaxMotion * tip_radius(shape)) : 0;
    if (substeps > kMaxSubsteps) forget_tool(tick.state, int(i));
    if (memory.seen) {
      substep_count = std::max(substep_count, int(std::ceil(substeps)));
      continue;
    }
    // a tool that appears may be inside the body
    memory.inside = is_inside(tick.deformed(), tool_position(shape, pose), bounding_radius(shape));
  }
  TURGOR_CHECK(substep_count >= 1 && substep_count <= kMaxSubsteps, "a tick has 1 to kMaxSubsteps substeps");
  return substep_count;
}

}  // namespace turgor::contact
