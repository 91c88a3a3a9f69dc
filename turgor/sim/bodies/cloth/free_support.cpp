#include "turgor/sim/bodies/cloth/free_support.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/cloth/contact/free_obstacle.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

/// Displaced vertices of a body of finite elements.
std::vector<Vec3d> displaced_vertices(const SfemBody& body, const std::vector<Vec3d>& displacement) {
  std::vector<Vec3d> x = body.model.body.mesh.vertices;
  TURGOR_CHECK(displacement.size() == x.size(), "every vertex has a displacement");
  for (std::size_t v = 0; v < x.size(); v++) x[v] += displacement[v];
  return x;
}

/// r² I − r rᵀ, times a mass.
void add_inertia(double mass, Vec3d r, Mat3d& sum) {
  for (int k = 0; k < 3; k++) {
    Vec3d axis;
    axis[k] = 1;
    sum.column[k] += mass * (axis * dot(r, r) - r * r[k]);
  }
}

Mat3d zero_matrix() { return {{{}, {}, {}}}; }

cloth::FreeInertia inertia_of(const RigidBody& body) {
  const rigid::MassProperties& mass = body.model.mass;
  cloth::FreeInertia inertia{.center = body.state.center, .mass = mass.mass, .inertia = zero_matrix()};
  const Mat3d axes = axes_of(body.state.rotation) * mass.axes;
  for (int axis = 0; axis < 3; axis++) {
    const Vec3d a = axes.column[axis];
    for (int k = 0; k < 3; k++) inertia.inertia.column[k] += a * (a[k] * mass.moments[axis]);
  }
  return inertia;
}

cloth::FreeInertia inertia_of(const SfemBody& body) {
  const std::vector<double>& mass = body.model.mass;
  const std::vector<Vec3d> x = displaced_vertices(body, body.flight->u);
  cloth::FreeInertia inertia{.mass = std::accumulate(mass.begin(), mass.end(), 0.0),
                             .inertia = zero_matrix()};
  for (std::size_t v = 0; v < x.size(); v++) inertia.center += x[v] * (mass[v] / inertia.mass);
  for (std::size_t v = 0; v < x.size(); v++) add_inertia(mass[v], x[v] - inertia.center, inertia.inertia);
  return inertia;
}

/// Load of the support that the prediction of this frame has, about a center.
contact::RigidLoad predicted_load(const World& world, const ClothSupport& support, Vec3d center) {
  if (support.body.kind == BodyKind::kRigid) return support.wrench;
  const SfemBody& body = world.sfem_bodies[std::size_t(support.body.index)];
  contact::RigidLoad load;
  for (const auto& [vertex, force] : support.relaxed) {
    const auto v = std::size_t(vertex);
    const Vec3d arm = body.model.body.mesh.vertices[v] + body.flight->u[v] - center;
    load.force += force, load.torque += cross(arm, force);
  }
  return load;
}

/// Changes the motion of the frame by an impulse.
void move(RigidBody& body, Vec3d impulse, Vec3d moment, double dt) {
  const rigid::State &from = body.state, &to = body.next;
  body.next = rigid::moved(body.model, from, (to.velocity - from.velocity) * body.model.mass.mass + impulse,
                           to.momentum - from.momentum + moment, dt);
}

/// The displacement is that of a rigid motion: the load of the next frame deforms the body.
void move(SfemBody& body, const cloth::FreeInertia& inertia, Vec3d impulse, Vec3d moment, double dt) {
  const Vec3d shift = impulse * (dt / inertia.mass), turn = inverse(inertia.inertia) * moment * dt;
  const std::vector<Vec3d> x = displaced_vertices(body, body.flight->u);
  if (body.free.before.empty()) body.free.before.resize(x.size());
  for (std::size_t v = 0; v < x.size(); v++) {
    const Vec3d moved = shift + cross(turn, x[v] - inertia.center);
    body.flight->displacement[v] += moved, body.free.before[v] += moved;
  }
}

/// visit(support) for every support of a body that moves with its cloth.
template <class Visit>
void for_each_free(World& world, BodyId body, const Visit& visit) {
  for (ClothBody& cloth : world.cloth_bodies)
    for (ClothObstacle& obstacle : cloth.obstacles)
      if (obstacle.support && obstacle.support->body == body && moves_with(world, cloth, body))
        visit(*obstacle.support);
}

}  // namespace

bool moves_with(const World& world, const ClothBody& cloth, BodyId body) {
  if (!cloth::uses_conjugate_gradients(cloth.model.params.solver.method)) return false;
  const auto n = std::size_t(body.index);
  if (body.kind == BodyKind::kRigid) return !world.rigid_bodies[n].model.is_fixed;
  return body.kind == BodyKind::kSfem && world.sfem_bodies[n].flight.has_value();
}

std::vector<Vec3> positions_before(const World& world, const ClothSupport& support) {
  const auto n = std::size_t(support.body.index);
  std::vector<Vec3> positions;
  if (support.body.kind == BodyKind::kRigid) {
    const RigidBody& body = world.rigid_bodies[n];
    const Pose pose = rigid::pose_of(body.model, body.state);
    for (const int v : support.carrier)
      positions.push_back(Vec3(to_world(pose, body.model.vertices[std::size_t(v)])));
    return positions;
  }
  const std::vector<Vec3d> x = displaced_vertices(world.sfem_bodies[n], world.sfem_bodies[n].flight->u);
  for (const int v : support.carrier) positions.push_back(Vec3(x[std::size_t(v)]));
  return positions;
}

double largest_speed(const ClothSupport& support) {
  TURGOR_ASSERT(support.moving != nullptr, "a support is updated before its speed is known");
  Real square = 0;
  for (const Vec3 v : support.moving->velocities) square = std::max(square, dot(v, v));
  return std::sqrt(double(square));
}

cloth::FreeInertia free_inertia(const World& world, const ClothSupport& support) {
  const auto n = std::size_t(support.body.index);
  cloth::FreeInertia inertia = support.body.kind == BodyKind::kRigid ? inertia_of(world.rigid_bodies[n])
                                                                     : inertia_of(world.sfem_bodies[n]);
  const contact::RigidLoad load = predicted_load(world, support, inertia.center);
  inertia.force = load.force, inertia.torque = load.torque, inertia.frame = world.dt;
  return inertia;
}

void move_support(const cloth::State& state, int obstacle, ClothSupport& support, World& world) {
  const auto n = std::size_t(support.body.index);
  // what the impulse of the frame differs from the predicted one
  const double dt = world.dt, frames = dt / state.impulse_time;
  const cloth::FreeInertia inertia = free_inertia(world, support);
  const cloth::ObstacleLoad load = cloth::free_obstacle_load(state, obstacle);
  const Vec3d impulse = load.impulse * frames, moment = load.moment * frames;
  support.pressing = {impulse / dt, moment / dt};
  const Vec3d more = impulse - inertia.force * dt, moment_more = moment - inertia.torque * dt;
  // motion
  if (support.body.kind == BodyKind::kRigid)
    move(world.rigid_bodies[n], more, moment_more, dt);
  else
    move(world.sfem_bodies[n], inertia, more, moment_more, dt);
}

void relax_free_loads(World& world, BodyId id) {
  const auto n = std::size_t(id.index);
  if (id.kind == BodyKind::kRigid) {
    RigidBody& body = world.rigid_bodies[n];
    const double p = body.cloth.relaxation;
    body.borne = {};
    for_each_free(world, id, [&](ClothSupport& support) {
      support.wrench.force += p * (support.pressing.force - support.wrench.force);
      support.wrench.torque += p * (support.pressing.torque - support.wrench.torque);
      body.borne.force += support.wrench.force, body.borne.torque += support.wrench.torque;
    });
  } else if (id.kind == BodyKind::kSfem) {
    const SfemBody& body = world.sfem_bodies[n];
    ClothLoad load;
    if (body.press) load.relaxation = body.press->load.relaxation;
    for_each_free(world, id, [&](ClothSupport& support) {
      load.force = std::move(support.relaxed);
      relax_toward({.force = support.force}, load);
      support.relaxed = std::move(load.force);
    });
  }
}

}  // namespace turgor
