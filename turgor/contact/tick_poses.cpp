#include <algorithm>
#include <cmath>

#include "turgor/contact/tick.hpp"

namespace turgor::contact {

namespace {

constexpr double kStep = 0.5;   // of the tip's radius: the farthest that a tool moves in one solution
constexpr int kMostSteps = 8;   // in a tick; a tool that moves farther has jumped
constexpr int kLetGoSteps = 3;  // what was held springs back far: the tools are looked at again on its way

Vec3d lerp(Vec3d a, Vec3d b, double t) { return a + t * (b - a); }

/// Axes that are between two orthonormal ones, orthonormal again.
Mat3d between(const Mat3d& a, const Mat3d& b, double t) {
  const Vec3d x = normalized(lerp(a.column[0], b.column[0], t)), y = lerp(a.column[1], b.column[1], t);
  const Vec3d z = normalized(cross(x, y));
  return norm(z) > 0.5 && norm(x) > 0.5 ? Mat3d{{x, cross(z, x), z}} : b;
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

}  // namespace

Pose Tick::pose(std::size_t tool) const {
  const Pose &from = state.tools[tool].pose, &to = poses[tool].pose;
  if (part >= 1 || !state.tools[tool].seen) return to;
  return {lerp(from.position, to.position, part), between(from.axes, to.axes, part)};
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

}  // namespace turgor::contact
