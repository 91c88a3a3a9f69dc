#include <algorithm>

#include "turgor/contact/cloth_obstacle.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/geometry/where_is.hpp"
#include "turgor/sim/bodies/cloth/cloth_body.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

/// A displacement at a time: straight between the rows, at rest before and after them.
Vec3d displacement_at(const std::vector<std::array<double, 4>>& path, double time) {
  const auto row = [&path](std::size_t n) { return Vec3d{path[n][1], path[n][2], path[n][3]}; };
  if (path.empty()) return {};
  if (time <= path.front()[0]) return row(0);
  for (std::size_t n = 1; n < path.size(); n++)
    if (time < path[n][0]) {
      const double f = (time - path[n - 1][0]) / (path[n][0] - path[n - 1][0]);
      return row(n - 1) * (1 - f) + row(n) * f;
    }
  return row(path.size() - 1);
}

/// The vertices in its ball, now that it takes hold.
void seize(const ClothBody& body, ClothHold& hold) {
  hold.vertices.clear();
  for (std::size_t v = 0; v < body.model.place.size(); v++) {
    const Vec3d x(body.state->x[std::size_t(body.model.place[v])]);
    if (norm(x - hold.scene.ball->center) <= hold.scene.ball->radius) hold.vertices.push_back(int(v));
  }
  if (!hold.vertices.empty()) return;
  std::vector<Vec3d> places;
  for (std::size_t v = 0; v < std::size_t(body.model.count); v++) places.emplace_back(body.state->x[v]);
  hold.missed = where_is(places, hold.scene.ball->center);
}

/// Seizes, moves or lets go; `end` is the time at the end of this frame. The vertices are there.
void follow(ClothBody& body, ClothHold& hold, double end) {
  const bool wanted = end > hold.scene.start && end <= hold.scene.end;
  if (wanted && !hold.is_held && hold.scene.ball) seize(body, hold);
  for (std::size_t n = 0; n < hold.vertices.size(); n++) {
    const int v = hold.vertices[n];
    if (wanted && !hold.is_held) {
      (void)body.state.hold(body.model, v);
      hold.places.push_back(body.state->x[std::size_t(body.model.place[std::size_t(v)])]);
    }
    if (wanted)
      (void)body.state.move_hold(body.model, v, hold.places[n] + Vec3(displacement_at(hold.scene.path, end)));
    if (!wanted && hold.is_held) (void)body.state.release(body.model, v);
  }
  hold.is_held = wanted;
  if (!wanted) hold.places.clear();
}

/// Layers of cloth keep a thickness apart: each has half of it around itself [m].
double tool_gap(const ClothBody& body) { return body.model.params.collision.thickness / 2; }

/// What the hold takes in this frame [N].
Vec3d force_of(const ClothBody& body, const ClothHold& hold, const cloth::Vectors& v_before,
               const World& world) {
  Vec3d sum;
  for (const int vertex : hold.vertices) {
    const auto v = std::size_t(body.model.place[std::size_t(vertex)]);
    const Vec3d change = Vec3d(body.state->v[v]) - Vec3d(v_before[v]);
    sum += cloth::hold_force(body.model, body.state, vertex, world.gravity, change, world.dt);
  }
  return sum;
}

/// How far a body gives way at most where a force like that of the cloth acts [m/N].
double compliance_of(const World& world, BodyId id) {
  constexpr double kCare = 2;
  const auto largest = [](const Vec3d& a) { return kCare * std::max({a.x, a.y, a.z}); };
  if (id.kind == BodyKind::kLattice) return largest(world.lattice_bodies[std::size_t(id.index)].cloth.answer);
  if (id.kind == BodyKind::kRhombus) return largest(world.rhombus_bodies[std::size_t(id.index)].cloth.answer);
  if (id.kind != BodyKind::kSfem) return 0;
  const SfemBody& body = world.sfem_bodies[std::size_t(id.index)];
  return body.press ? largest(body.press->load.answer) : 0;
}

cloth::Obstacle made(const Exec& exec, ClothObstacle& obstacle, World& world) {
  cloth::Obstacle result;
  if (obstacle.plane)
    result = cloth::plane_obstacle(obstacle.plane->through, obstacle.plane->normal);
  else if (obstacle.shape)
    result = contact::cloth_obstacle(*obstacle.shape, obstacle.pose, obstacle.pose, world.dt);
  else if (obstacle.surface)
    result = cloth::surface_obstacle(obstacle.surface);
  else
    follow_body(exec, *obstacle.support, world), result = cloth::surface_obstacle(obstacle.support->moving);
  result.friction = obstacle.friction, result.gap = obstacle.gap;
  if (obstacle.support) result.compliance = compliance_of(world, obstacle.support->body);
  return result;
}

/// The tools on their way through this frame, behind the scene's obstacles.
void add_tools(ClothBody& body, const World& world, const FrameInput& input, cloth::Inputs& inputs) {
  for (std::size_t t = 0; t < body.tools.size(); t++) {
    const TouchingTool& tool = world.tools[std::size_t(body.tool_indices[t])];
    if (!body.haptic.empty() && body.haptic[t].was_teleported)
      body.poses[t] = command_at(tool, input.from).pose;
    const contact::Pose to = command_at(tool, input.to).pose;
    inputs.obstacles.push_back(contact::cloth_tool(body.tools[t].shape, body.poses[t], to, world.dt));
    inputs.obstacles.back().friction = body.tools[t].friction;
    inputs.obstacles.back().gap = tool_gap(body);
  }
}

/// What the tools felt in this frame, and where they are now.
void note_tools(ClothBody& body, World& world, double time, double seconds) {
  for (std::size_t t = 0; t < body.tools.size(); t++) {
    TouchingTool& tool = world.tools[std::size_t(body.tool_indices[t])];
    const contact::ToolCommand command = command_at(tool, time);
    const int obstacle = int(body.obstacles.size() + t);
    const cloth::ObstacleLoad load = cloth::obstacle_load(body.state, obstacle, command.pose.position);
    body.poses[t] = command.pose;
    body.forces[t] = {.force = load.impulse / body.state->impulse_time,
                      .torque = load.moment / body.state->impulse_time};
    for (const cloth::Contact& c : body.state->contacts.list)
      body.forces[t].contacts += c.obstacle == obstacle && c.impulse > 0;
    const contact::ToolForce& haptic = body.forces[t];
    ForceSample sample = sample_of(
        time, command, {.force = haptic.force, .torque = haptic.torque, .contacts = haptic.contacts});
    sample.tick_seconds = float(seconds);
    tool.samples.append(sample);
  }
}

/// What ticks feel until the next frame.
void leave_planes(ClothBody& body) {
  for (std::size_t t = 0; t < body.haptic.size(); t++)
    leave_plane(body, t,
                contact::local_contact(body.model, body.state, int(body.obstacles.size() + t), tool_gap(body),
                                       body.tools[t], body.poses[t], body.state->impulse_time,
                                       body.haptic[t].memory));
}

}  // namespace

void step_body(const Exec& exec, ClothBody& body, World& world, const FrameInput& input, FrameReport& frame) {
  const auto [begin, end, measure] = input;
  for (ClothHold& hold : body.holds) follow(body, hold, end);
  for (const WindTurn& turn : body.turns)
    if (turn.time <= begin) body.air.velocity = turn.velocity;
  cloth::Inputs inputs{.gravity = world.gravity, .air = body.air, .measure_residual = measure};
  for (ClothObstacle& obstacle : body.obstacles) inputs.obstacles.push_back(made(exec, obstacle, world));
  take_commands(body, begin, end, world.tools);
  add_tools(body, world, input, inputs);

  const bool is_held =
      std::any_of(body.holds.begin(), body.holds.end(), [](const ClothHold& hold) { return hold.is_held; });
  const cloth::Vectors v_before = is_held ? body.state->v : cloth::Vectors();
  const Timer timer;
  const cloth::StepReport report = body.state.step(exec, body.model, inputs, world.dt);
  ClothSample sample{.time = end,
                     .seconds = timer.seconds(),
                     .largest_speed = report.largest_speed,
                     .residual = report.residual,
                     .iterations = report.iterations,
                     .is_snapshot = measure,
                     .contacts = report.contacts};
  for (std::size_t o = 0; o < body.obstacles.size(); o++) {
    ClothObstacle& obstacle = body.obstacles[o];
    obstacle.force.push_back(cloth::obstacle_load(body.state, int(o), {}).impulse / body.state->impulse_time);
    if (obstacle.support) note_force(body.state, int(o), body.state->impulse_time, *obstacle.support);
  }
  note_tools(body, world, end, sample.seconds);
  leave_planes(body);
  for (ClothHold& hold : body.holds)
    hold.force.push_back(hold.is_held ? force_of(body, hold, v_before, world) : Vec3d{});
  if (measure) {
    const cloth::Energy energy = cloth::energy(body.model, body.state, world.gravity);
    sample.energy = energy.elastic + energy.kinetic;
    sample.stretch = cloth::largest_stretch(body.model, body.state);
  }
  body.samples.push_back(sample);
  frame.finite = frame.finite && report.finite;
  frame.largest_speed = std::max(frame.largest_speed, double(report.largest_speed));
}

}  // namespace turgor
