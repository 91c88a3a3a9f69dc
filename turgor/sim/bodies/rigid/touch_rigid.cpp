#include "turgor/sim/bodies/rigid/touch_rigid.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "turgor/contact/touch_tick.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/geometry/box.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

constexpr int kMostSites = 64;               // of a tool
constexpr int kToolHere = 0, kBodyHere = 1;  // numbers in a search outside of the coupling

/// Pose of `inner` in the frame of `outer`.
Pose relative(const Pose& outer, const Pose& inner) {
  return {to_tool(outer, inner.position), transposed(outer.axes) * inner.axes};
}

/// Surface of a tool in the frame of its origin; `x` receives the present positions of its mesh.
contact::PairSurface tool_surface(const RigidTouch& touch, int index, std::vector<Vec3d>& rest,
                                  std::vector<Vec3d>& x) {
  for (const Vec3 v : touch.mesh.vertices) rest.emplace_back(v), x.push_back(to_world(touch.pose, Vec3d(v)));
  contact::PairSurface surface{index, rest, x, touch.mesh.triangles, {}};
  const auto set_round = [&](double radius, double half_length) {
    const Vec3d end{0, 0, half_length};
    surface.round =
        contact::RoundSurface{radius, {to_world(touch.pose, -end), to_world(touch.pose, end)}, touch.pose};
  };
  if (const auto* ball = std::get_if<contact::Sphere>(&touch.tool.shape)) set_round(ball->radius, 0);
  if (const auto* rod = std::get_if<contact::Capsule>(&touch.tool.shape))
    set_round(rod->radius, rod->half_length);
  return surface;
}

/// Smallest extent of the body [m].
double thickness(const RigidBody& body) {
  const Box box = box_around(body.model.vertices);
  const Vec3d size = box.high - box.low;
  return std::min({size.x, size.y, size.z});
}

/// Distance within which a tangent plane stands for the body between frames [m].
double plane_reach(const RigidBody& body, const RigidTouch& touch) {
  return std::max(touch.radius, thickness(body) / 2);
}

/// Distances within which sites are found: beyond what body and tool may move in the next frame.
contact::PairParams site_params(const RigidBody& body, const RigidTouch& touch, const World& world) {
  constexpr double kReach = 0.05, kDeepest = 0.5;  // of an extent
  const double extent = thickness(body), tip = 2 * touch.radius;
  const double moved =
      contact::motion(touch.tool.shape, touch.pose, touch.next) +
      world.dt * (rigid::largest_speed(body.model, body.state) + world.dt * norm(world.gravity));
  return {.gap = 0,
          .reach = kReach * std::min(extent, tip) + moved,
          .deepest = kDeepest * std::min(extent, tip) + moved,
          .friction = touch.tool.friction,
          .capacity = kMostSites};
}

/// Springs between the tool and six points of the body around the tool's origin, which together have this
/// stiffness.
std::vector<contact::Tie> grasp_springs(const RigidBody& body, const RigidTouch& touch, int index, int tool) {
  const Pose pose = rigid::pose_of(body.model, body.state);
  const Vec3d center = to_tool(pose, touch.pose.position);
  std::vector<contact::Tie> springs;
  for (int n = 0; n < 6; n++) {
    Vec3d point = center;
    point[n / 2] += (n % 2 ? -1 : 1) * touch.radius;
    springs.push_back({.a = {index, {-1, -1, -1}, {}, point},
                       .b = {tool, {-1, -1, -1}, {}, point},
                       .stiffness = body.touch_stiffness / 6,
                       .force = {}});
  }
  return springs;
}

bool bears(const std::vector<contact::PairSite>& sites) {
  return std::any_of(sites.begin(), sites.end(),
                     [](const contact::PairSite& site) { return site.force != Vec3d{}; });
}

/// A grasp begins with the command if the tool touches the body, and ends with it.
void update_grasp(const RigidBody& body, bool held_before, int index, int tool, RigidTouch& touch) {
  if (!touch.hold) {
    touch.grasped.reset(), touch.grasp.clear();
  } else if (!held_before && bears(touch.sites)) {
    touch.grasped = relative(touch.pose, rigid::pose_of(body.model, body.state));
    touch.grasp = grasp_springs(body, touch, index, tool);
  }
}

/// Contact of a frame between the tool and the nearest sites. The plane's stiffness is that of the points
/// that bear force.
contact::LocalContact plane_of(const RigidBody& body, const RigidTouch& touch, const contact::PairSites& near,
                               double gap) {
  contact::LocalContact plane{.is_near = !near.sites.empty() || touch.grasped,
                              .is_held = touch.grasped.has_value(),
                              .origin = touch.pose.position,
                              .force = touch.force.force,
                              .gap = touch.force.contacts > 0 ? 0 : std::max(0.0, gap),
                              .friction = touch.tool.friction,
                              .reach = plane_reach(body, touch)};
  plane.stiffness = plane.shear_stiffness = body.touch_stiffness * std::max(1, touch.force.contacts);
  // normal of the nearest site, or the mean over those within the tool
  Vec3d normal;
  double nearest = HUGE_VAL;
  for (const contact::PairSite& site : near.sites) {
    const Vec3d out = site.a.body == kToolHere ? site.normal : -site.normal;
    normal += std::max(0.0, -site.distance) * out;
    if (site.distance < nearest) nearest = site.distance, plane.normal = out;
  }
  if (norm(normal) > 0) plane.normal = normalized(normal);
  if (touch.grasped) plane.stiffness = plane.shear_stiffness = body.touch_stiffness;
  // the torque is that of the force at the arm: its part across the force
  const double square = dot(plane.force, plane.force);
  if (square > 0) plane.arm = cross(plane.force, touch.force.torque) / square;
  return plane;
}

}  // namespace

contact::PairSurface rigid_surface(const RigidBody& body, int index, std::span<const Vec3d> x) {
  contact::PairSurface surface{index, body.model.vertices, x, body.model.triangles, {}};
  const rigid::RoundShape& round = body.model.round;
  const Pose pose = rigid::pose_of(body.model, body.state);
  if (round.radius > 0)
    surface.round = contact::RoundSurface{
        round.radius, {to_world(pose, round.ends[0]), to_world(pose, round.ends[1])}, pose};
  return surface;
}

Status begin_body(const Exec&, RigidBody& body, const RigidScene&, const World& world) {
  for (const int t : body.tool_indices) {
    const TouchingTool& tool = world.tools[std::size_t(t)];
    const Pose pose = command_at(tool, 0).pose;
    body.touches.push_back({.tool = tool.tool,
                            .mesh = tool.mesh,
                            .radius = contact::tip_radius(tool.tool.shape),
                            .pose = pose,
                            .next = pose,
                            .grasped = {},
                            .sites = {},
                            .grasp = {},
                            .load = {},
                            .force = {}});
  }
  return Done{};
}

contact::RigidMotion tool_motion(const RigidTouch& touch) {
  const Pose grasped = touch.grasped.value_or(Pose{});
  contact::RigidMotion motion{.rest_center = to_tool(grasped, {}),
                              .before = {touch.pose.position, touch.pose.axes * grasped.axes},
                              .after = {},
                              .shift = {},
                              .turn = {}};
  contact::linearize({touch.next.position, touch.next.axes * grasped.axes}, {}, motion);
  return motion;
}

void find_tool_sites(const Exec& exec, const World& world, RigidBody& body, int index, int first_tool,
                     const contact::PairSurface& surface, double end) {
  for (std::size_t t = 0; t < body.touches.size(); t++) {
    // motion of the next frame; a teleported tool begins again
    RigidTouch& touch = body.touches[t];
    const int number = body.tool_indices[t], tool = first_tool + number;
    const contact::ToolCommand command = command_at(world.tools[std::size_t(number)], end);
    const bool held_before = std::exchange(touch.hold, command.hold);
    touch.next = command.pose;
    if (!body.haptic.empty() && body.haptic[t].was_teleported)
      touch.pose = touch.next, touch.sites.clear(), touch.grasp.clear(), touch.grasped.reset();
    // grasp, or sites at the present poses
    update_grasp(body, held_before, index, tool, touch);
    if (touch.grasped) {
      touch.sites.clear();
      continue;
    }
    std::vector<Vec3d> rest, x;
    const contact::PairSurface of_tool = tool_surface(touch, tool, rest, x);
    touch.sites =
        contact::find_pair_sites(exec, {of_tool, surface}, site_params(body, touch, world), touch.sites)
            .sites;
    for (contact::PairSite& site : touch.sites) site.softness = 1 / body.touch_stiffness;
  }
}

void read_tool_loads(RigidBody& body, int first_tool) {
  for (std::size_t t = 0; t < body.touches.size(); t++) {
    RigidTouch& touch = body.touches[t];
    const int tool = first_tool + body.tool_indices[t];
    touch.load = contact::load_on(tool, tool_motion(touch), touch.grasp, touch.sites);
  }
}

void record_touch(const Exec& exec, RigidBody& body, World& world, double time) {
  if (body.touches.empty()) return;
  // surface of the body
  const Pose pose = rigid::pose_of(body.model, body.state);
  std::vector<Vec3d> x_body;
  for (const Vec3d v : body.model.vertices) x_body.push_back(to_world(pose, v));
  const contact::PairSurface of_body = rigid_surface(body, kBodyHere, x_body);

  for (std::size_t t = 0; t < body.touches.size(); t++) {
    // force of the frame that ends
    RigidTouch& touch = body.touches[t];
    touch.pose = touch.next;
    touch.force = {.force = touch.load.force, .torque = touch.load.torque};
    for (const contact::PairSite& site : touch.sites) {
      touch.force.contacts += site.force != Vec3d{};
      touch.force.sliding += site.state == contact::SiteState::kSlip;
    }
    touch.force.contacts += touch.grasped.has_value();
    // depth, and the plane for ticks
    std::vector<Vec3d> rest, x_tool;
    const contact::PairSurface of_tool = tool_surface(touch, kToolHere, rest, x_tool);
    contact::PairParams params = site_params(body, touch, world);
    params.reach = std::max(params.reach, plane_reach(body, touch));
    const contact::PairSites near = contact::find_pair_sites(exec, {of_tool, of_body}, params, {});
    TouchingTool& tool = world.tools[std::size_t(body.tool_indices[t])];
    contact::ToolCommand command = command_at(tool, time);
    command.pose = touch.pose;
    const contact::ToolReading reading{.force = touch.force.force,
                                       .torque = touch.force.torque,
                                       .depth = near.deepest,
                                       .contacts = touch.force.contacts};
    tool.samples.append(sample_of(time, command, reading));
    if (body.haptic.empty()) continue;
    double gap = HUGE_VAL;
    for (const contact::PairSite& site : near.sites) gap = std::min(gap, site.distance);
    publish_contact(body, t, plane_of(body, touch, near, gap));
  }
}

}  // namespace turgor
