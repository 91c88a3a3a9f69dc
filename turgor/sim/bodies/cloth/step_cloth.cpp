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
    const Vec3d x(body.state.x[std::size_t(body.model.place[v])]);
    if (norm(x - hold.scene.ball->centre) <= hold.scene.ball->radius) hold.vertices.push_back(int(v));
  }
  if (!hold.vertices.empty()) return;
  std::vector<Vec3d> places;
  for (std::size_t v = 0; v < std::size_t(body.model.count); v++) places.emplace_back(body.state.x[v]);
  hold.missed = where_is(places, hold.scene.ball->centre);
}

/// Seizes, moves or lets go; `end` is the time at the end of this frame. The vertices are there.
void follow(ClothBody& body, ClothHold& hold, double end) {
  const bool wanted = end > hold.scene.start && end <= hold.scene.end;
  if (wanted && !hold.is_held && hold.scene.ball) seize(body, hold);
  for (std::size_t n = 0; n < hold.vertices.size(); n++) {
    const int v = hold.vertices[n];
    if (wanted && !hold.is_held) {
      (void)cloth::hold(body.model, body.state, v);
      hold.places.push_back(body.state.x[std::size_t(body.model.place[std::size_t(v)])]);
    }
    if (wanted)
      (void)cloth::move_hold(body.model, body.state, v,
                             hold.places[n] + Vec3(displacement_at(hold.scene.path, end)));
    if (!wanted && hold.is_held) (void)cloth::release(body.model, body.state, v);
  }
  hold.is_held = wanted;
  if (!wanted) hold.places.clear();
}

/// What the hold takes in this frame [N].
Vec3d force_of(const ClothBody& body, const ClothHold& hold, const cloth::Vectors& v_before,
               const World& world) {
  Vec3d sum;
  for (const int vertex : hold.vertices) {
    const auto v = std::size_t(body.model.place[std::size_t(vertex)]);
    const Vec3d change = Vec3d(body.state.v[v]) - Vec3d(v_before[v]);
    sum += cloth::hold_force(body.model, body.state, vertex, world.gravity, change, world.dt);
  }
  return sum;
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
  return result;
}

}  // namespace

void step_body(const Exec& exec, ClothBody& body, World& world, const FrameInput& input, FrameReport& frame) {
  const auto [begin, end, measure] = input;
  for (ClothHold& hold : body.holds) follow(body, hold, end);
  for (const WindTurn& turn : body.turns)
    if (turn.time <= begin) body.air.velocity = turn.velocity;
  cloth::Inputs inputs{.gravity = world.gravity, .air = body.air, .measure_residual = measure};
  for (ClothObstacle& obstacle : body.obstacles) inputs.obstacles.push_back(made(exec, obstacle, world));

  const cloth::Vectors v_before = body.state.v;
  const Timer timer;
  const cloth::StepReport report = cloth::step(exec, body.model, body.state, inputs, world.dt);
  ClothSample sample{.time = end,
                     .seconds = timer.seconds(),
                     .largest_speed = report.largest_speed,
                     .contacts = report.contacts};
  for (std::size_t o = 0; o < body.obstacles.size(); o++) {
    ClothObstacle& obstacle = body.obstacles[o];
    obstacle.force.push_back(cloth::obstacle_load(body.state, int(o), {}).impulse / world.dt);
    if (obstacle.support) note_force(body.state, int(o), world.dt, *obstacle.support);
  }
  for (ClothHold& hold : body.holds)
    hold.force.push_back(hold.is_held ? force_of(body, hold, v_before, world) : Vec3d{});
  if (measure) {
    const cloth::Energy energy = cloth::energy(body.model, body.state, world.gravity);
    sample.residual = report.residual;
    sample.energy = energy.elastic + energy.kinetic;
    sample.stretch = cloth::largest_stretch(body.model, body.state);
  }
  body.samples.push_back(sample);
  frame.finite = frame.finite && report.finite;
  frame.largest_speed = std::max(frame.largest_speed, double(report.largest_speed));
}

}  // namespace turgor
