#include <algorithm>
#include <span>
#include <vector>

#include "turgor/contact/cloth_obstacle.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/geometry/body_location.hpp"
#include "turgor/models/cloth/contact/contact.hpp"
#include "turgor/sim/bodies/cloth/cloth_body.hpp"
#include "turgor/sim/bodies/cloth/corner_forces.hpp"
#include "turgor/sim/bodies/cloth/free_support.hpp"
#include "turgor/sim/bodies/lack_of_memory.hpp"
#include "turgor/sim/organs/cloth_attachments.hpp"
#include "turgor/sim/organs/tied_cloths.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

/// Displacement at a time: linear between the rows, constant before and after them.
Vec3d displacement_at(const std::vector<std::array<double, 4>>& path, double time) {
  const auto row = [&path](std::size_t n) { return Vec3d{path[n][1], path[n][2], path[n][3]}; };
  if (path.empty()) return {};
  if (time <= path.front()[0]) return row(0);
  for (std::size_t n = 1; n < path.size(); n++)
    if (time < path[n][0]) {
      TURGOR_CHECK(path[n][0] > path[n - 1][0], "the times of a path ascend");
      const double f = (time - path[n - 1][0]) / (path[n][0] - path[n - 1][0]);
      return row(n - 1) * (1 - f) + row(n) * f;
    }
  return row(path.size() - 1);
}

/// Selects the vertices inside the hold's ball.
void find_vertices_in_ball(const ClothBody& body, ClothHold& hold) {
  hold.vertices.clear();
  for (std::size_t v = 0; v < body.model.model_vertex.size(); v++) {
    const Vec3d x(body.state->x[std::size_t(body.model.model_vertex[v])]);
    if (norm(x - hold.scene.ball->center) <= hold.scene.ball->radius) hold.vertices.push_back(int(v));
  }
  if (!hold.vertices.empty()) return;
  std::vector<Vec3d> positions;
  for (std::size_t v = 0; v < std::size_t(body.model.count); v++) positions.emplace_back(body.state->x[v]);
  hold.missed = describe_location(positions, hold.scene.ball->center);
}

/// Grasps, moves or releases the vertices of a hold; `end` is the end of this frame.
void update_hold(ClothBody& body, ClothHold& hold, double end) {
  // grasp at the start
  const bool holds = end > hold.scene.start && end <= hold.scene.end;
  if (holds && !hold.is_held && hold.scene.ball) find_vertices_in_ball(body, hold);

  // move or release every vertex
  for (std::size_t n = 0; n < hold.vertices.size(); n++) {
    const int v = hold.vertices[n];
    if (holds && !hold.is_held) {
      (void)body.state.hold(body.model, v);
      hold.positions.push_back(body.state->x[std::size_t(body.model.model_vertex[std::size_t(v)])]);
    }
    if (holds)
      (void)body.state.move_hold(body.model, v,
                                 hold.positions[n] + Vec3(displacement_at(hold.scene.path, end)));
    if (!holds && hold.is_held) (void)body.state.release(body.model, v);
  }
  hold.is_held = holds;
  if (!holds) hold.positions.clear();
}

/// Distance between tool and cloth: half the thickness between layers [m].
double tool_gap(const ClothBody& body) { return body.model.params.collision.thickness / 2; }

/// Vertices of the mesh that are held now, by hold and without order.
std::vector<int> held_vertices(const ClothBody& body) {
  std::vector<int> held;
  for (const ClothHold& hold : body.holds)
    if (hold.is_held) held.insert(held.end(), hold.vertices.begin(), hold.vertices.end());
  return held;
}

/// Velocities of held vertices, in the order of held_vertices [m/s].
std::vector<Vec3> held_velocities(const ClothBody& body) {
  std::vector<int> vertices = held_vertices(body);
  if (vertices.empty()) return {};
  for (int& v : vertices) v = body.model.model_vertex[std::size_t(v)];
  return body.state.read_vertices(vertices, [&](const cloth::State& state) {
    std::vector<Vec3> velocities;
    for (const int v : vertices) velocities.push_back(state.v[std::size_t(v)]);
    return velocities;
  });
}

/// Force on the hold in this frame [N]. `v_before`: velocities of its vertices before it, then those
/// of others.
Vec3d hold_force_of(const ClothBody& body, const cloth::State& state, const ClothHold& hold,
                    std::span<const Vec3> v_before, const World& world) {
  TURGOR_CHECK(v_before.size() >= hold.vertices.size(), "every vertex has a velocity before the step");
  Vec3d sum;
  for (std::size_t n = 0; n < hold.vertices.size(); n++) {
    const auto v = std::size_t(body.model.model_vertex[std::size_t(hold.vertices[n])]);
    const Vec3d change = Vec3d(state.v[v]) - Vec3d(v_before[n]);
    sum += cloth::hold_force(body.model, state, hold.vertices[n], world.gravity, change, world.dt);
  }
  return sum;
}

/// Bound of the displacement of a body per force of the cloth [m/N].
double compliance_of(const World& world, BodyId id) {
  constexpr double kCare = 2;
  const auto largest = [](const Vec3d& a) { return kCare * std::max({a.x, a.y, a.z}); };
  if (id.kind == BodyKind::kLattice)
    return largest(world.lattice_bodies[std::size_t(id.index)].cloth.compliance);
  if (id.kind == BodyKind::kRhombus)
    return largest(world.rhombus_bodies[std::size_t(id.index)].cloth.compliance);
  if (id.kind == BodyKind::kRigid) return largest(world.rigid_bodies[std::size_t(id.index)].cloth.compliance);
  if (id.kind != BodyKind::kSfem) return 0;
  const SfemBody& body = world.sfem_bodies[std::size_t(id.index)];
  return body.press ? largest(body.press->load.compliance) : 0;
}

cloth::Obstacle make_obstacle(const Exec& exec, const ClothBody& body, ClothObstacle& obstacle,
                              World& world) {
  TURGOR_CHECK(int(obstacle.plane.has_value()) + int(obstacle.shape.has_value()) +
                       int(obstacle.surface != nullptr) + int(obstacle.support.has_value()) ==
                   1,
               "an obstacle has exactly one shape");
  // shape
  cloth::Obstacle result;
  const bool is_free = obstacle.support && moves_with(world, body, obstacle.support->body);
  if (obstacle.plane)
    result = cloth::plane_obstacle(obstacle.plane->through, obstacle.plane->normal);
  else if (obstacle.shape)
    result = contact::cloth_obstacle(*obstacle.shape, obstacle.pose, obstacle.pose, world.dt);
  else if (obstacle.surface)
    result = cloth::surface_obstacle(obstacle.surface);
  else
    update_support(exec, *obstacle.support, is_free, world),
        result = cloth::surface_obstacle(obstacle.support->moving);

  // contact parameters
  result.friction = obstacle.friction, result.gap = obstacle.gap;
  if (is_free)
    result.free = free_inertia(world, *obstacle.support), result.speed = largest_speed(*obstacle.support);
  else if (obstacle.support)
    result.compliance = compliance_of(world, obstacle.support->body);
  return result;
}

/// Adds the moving tools of this frame after the scene's obstacles.
void add_tools(ClothBody& body, const World& world, const FrameInput& input, cloth::Inputs& inputs) {
  TURGOR_CHECK(body.poses.size() == body.tools.size() && body.tool_indices.size() == body.tools.size(),
               "one pose a tool");
  TURGOR_CHECK(body.haptic.empty() || body.haptic.size() == body.tools.size(),
               "a haptic thread serves all tools");
  for (std::size_t t = 0; t < body.tools.size(); t++) {
    // restart the motion of a teleported tool
    const TouchingTool& tool = world.tools[std::size_t(body.tool_indices[t])];
    if (!body.haptic.empty() && body.haptic[t].was_teleported)
      body.poses[t] = command_at(tool, input.from).pose;
    // obstacle that moves from the last pose to the commanded one
    const contact::Pose to = command_at(tool, input.to).pose;
    inputs.obstacles.push_back(contact::cloth_tool(body.tools[t].shape, body.poses[t], to, world.dt));
    inputs.obstacles.back().friction = body.tools[t].friction;
    inputs.obstacles.back().gap = tool_gap(body);
  }
}

/// Records forces and poses of the tools in this frame.
void record_tools(ClothBody& body, World& world, double time, double seconds) {
  TURGOR_CHECK(is_step_length(body.state.impulse_time()),
               "impulses become forces over a step of positive length");
  for (std::size_t t = 0; t < body.tools.size(); t++) {
    // force on the tool from contact impulses
    TouchingTool& tool = world.tools[std::size_t(body.tool_indices[t])];
    const contact::ToolCommand command = command_at(tool, time);
    const int obstacle = int(body.obstacles.size() + t);
    const cloth::ObstacleLoad load = cloth::obstacle_load(body.state, obstacle, command.pose.position);
    body.poses[t] = command.pose;
    body.forces[t] = {.force = load.impulse / body.state->impulse_time,
                      .torque = load.moment / body.state->impulse_time};
    for (const cloth::Contact& c : body.state->contacts.list)
      body.forces[t].contacts += c.obstacle == obstacle && c.impulse > 0;

    // log
    const contact::ToolForce& haptic = body.forces[t];
    ForceSample sample = sample_of(
        time, command, {.force = haptic.force, .torque = haptic.torque, .contacts = haptic.contacts});
    sample.tick_seconds = float(seconds);
    tool.samples.append(sample);
  }
}

/// Publishes contact planes for the ticks until the next frame.
void publish_contacts(ClothBody& body) {
  for (std::size_t t = 0; t < body.haptic.size(); t++)
    publish_contact(body, t,
                    contact::local_contact(body.model, body.state, int(body.obstacles.size() + t),
                                           tool_gap(body), body.tools[t], body.poses[t],
                                           body.state.impulse_time(), body.haptic[t].history));
}

/// Inputs of the next step: holds, wind, obstacles, and springs to other bodies than cloth.
ClothStep prepare_step(const Exec& exec, ClothBody& body, World& world, const FrameInput& input) {
  const auto [begin, end, measure] = input;
  TURGOR_CHECK(end > begin, "a frame has a positive length");
  for (ClothHold& hold : body.holds) update_hold(body, hold, end);
  for (const WindTurn& turn : body.turns)
    if (turn.time <= begin) body.air.velocity = turn.velocity;

  // obstacles: those of the scene, then the tools
  cloth::Inputs inputs{.gravity = world.gravity, .air = body.air, .measure_residual = measure};
  for (ClothObstacle& obstacle : body.obstacles)
    inputs.obstacles.push_back(make_obstacle(exec, body, obstacle, world));
  apply_commands(body, begin, end, world.tools);
  add_tools(body, world, input, inputs);
  inputs.springs = attachment_springs(exec, body, world);

  ClothStep step{.body = body, .inputs = std::move(inputs)};
  step.v_before = held_velocities(body);
  return step;
}

/// Records the forces of this frame on obstacles and holds. Of a state on the device, only what determines
/// them is downloaded.
void record_forces(const ClothStep& step, World& world) {
  ClothBody& body = step.body;
  std::vector<int> read;
  if (body.state.is_on_device()) read = cloth::vertices_of_hold_forces(body.model, held_vertices(body));
  body.state.read_loads(body.model, read, [&](const cloth::State& state) {
    // obstacles
    for (std::size_t o = 0; o < body.obstacles.size(); o++) {
      ClothObstacle& obstacle = body.obstacles[o];
      obstacle.force.push_back(cloth::obstacle_load(state, int(o), {}).impulse / state.impulse_time);
      if (!obstacle.support) continue;
      record_force(state, int(o), state.impulse_time, *obstacle.support);
      move_to_corners(world, *obstacle.support);
      if (moves_with(world, body, obstacle.support->body))
        move_support(state, int(o), *obstacle.support, world);
    }
    // holds
    std::span<const Vec3> v_before = step.v_before;
    for (ClothHold& hold : body.holds) {
      hold.force.push_back(hold.is_held ? hold_force_of(body, state, hold, v_before, world) : Vec3d{});
      if (hold.is_held) v_before = v_before.subspan(hold.vertices.size());
    }
  });
}

/// Reads forces and measurements after the step.
void finish_step(const Exec& exec, const ClothStep& step, World& world, const FrameInput& input,
                 FrameReport& frame) {
  ClothBody& body = step.body;
  const cloth::StepReport& report = step.report;
  ClothSample sample{.time = input.to,
                     .seconds = step.seconds,
                     .largest_speed = report.largest_speed,
                     .residual = report.residual,
                     .iterations = report.iterations,
                     .is_snapshot = input.measure_residual,
                     .contacts = report.contacts};
  if (body.state.take_lack_of_memory()) body.notes.push_back(note_of_lacking_memory(input.from));
  if (report.finite && !step.inputs.springs.empty()) finish_attachment_springs(exec, body, world);

  // contact forces on obstacles, holds and tools
  if (!body.obstacles.empty() || !body.holds.empty()) record_forces(step, world);
  record_tools(body, world, input.to, sample.seconds);
  publish_contacts(body);

  // measurements
  if (input.measure_residual) {
    const cloth::Energy energy = cloth::energy(body.model, body.state, world.gravity);
    sample.energy = energy.elastic + energy.kinetic;
    sample.stretch = cloth::largest_stretch(body.model, body.state);
  }
  body.samples.push_back(sample);
  frame.finite = frame.finite && report.finite;
  frame.largest_speed = std::max(frame.largest_speed, double(report.largest_speed));
}

}  // namespace

void step_body(const Exec& exec, ClothBody& body, World& world, const FrameInput& input, FrameReport& frame) {
  // cloths that are tied to each other step with the first of them
  const int index = int(&body - world.cloth_bodies.data());
  const std::vector<int> order = cloths_stepped_with(world, index);
  if (index != *std::min_element(order.begin(), order.end())) return;
  std::vector<ClothStep> steps;
  for (const int cloth : order)
    steps.push_back(prepare_step(exec, world.cloth_bodies[std::size_t(cloth)], world, input));
  if (steps.size() > 1) {
    step_tied_cloths(exec, world, steps);
  } else {
    const Timer timer;
    steps[0].report = body.state.step(exec, body.model, steps[0].inputs, world.dt);
    steps[0].seconds = timer.seconds();
  }
  for (const ClothStep& step : steps) finish_step(exec, step, world, input, frame);
}

}  // namespace turgor
