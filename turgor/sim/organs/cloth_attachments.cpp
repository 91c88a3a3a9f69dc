#include "turgor/sim/organs/cloth_attachments.hpp"

#include <algorithm>
#include <numeric>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/cloth/forces/vertex_springs.hpp"
#include "turgor/sim/organs/support.hpp"
#include "turgor/sim/organs/swept.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

/// Points of a tie: that of the cloth, whose step solves for the force, and the other one.
const contact::SurfacePoint& cloth_point(const Attachment& attachment, const contact::Tie& tie) {
  return attachment.swept == 0 ? tie.a : tie.b;
}
const contact::SurfacePoint& other_point(const Attachment& attachment, const contact::Tie& tie) {
  return attachment.swept == 0 ? tie.b : tie.a;
}

/// Support of a cloth, or null.
const CoupledSupport* cloth_support(const World& world, const ClothBody& body) {
  for (const CoupledSupport& support : world.coupling.supports)
    if (support.body.kind == BodyKind::kCloth &&
        &world.cloth_bodies[std::size_t(support.body.index)] == &body)
      return &support;
  return nullptr;
}

/// Displacement of all vertices of a body at the end of the frame [m].
std::vector<Vec3d> displacement_at_end(const Exec& exec, const World& world, int index) {
  const BodyId id = coupled_body(world, index);
  if (id.kind == BodyKind::kSfem) return coarse_displacements(exec, world.sfem_bodies[std::size_t(id.index)]);
  if (id.kind == BodyKind::kRigid) {
    const RigidBody& body = world.rigid_bodies[std::size_t(id.index)];
    const Pose pose = rigid::pose_of(body.model, body.next);
    std::vector<Vec3d> displacement;
    for (const Vec3d rest : body.model.vertices) displacement.push_back(to_world(pose, rest) - rest);
    return displacement;
  }
  return support_displacement(world, world.coupling.supports[std::size_t(index - first_support(world))]);
}

/// Bound of the acceleration of a point of a rigid body at rest per force [1/kg].
double mobility(const RigidBody& body, Vec3d at) {
  const Mat3d inverse = rigid::inverse_inertia(body.model, {1, 0, 0, 0});
  double sum = 1 / body.model.mass.mass;
  for (int axis = 0; axis < 3; axis++) {
    Vec3d force;
    force[axis] = 1;
    const Vec3d torque = cross(at - body.model.mass.center, force);
    sum += dot(torque, inverse * torque);
  }
  return sum;
}

/// visit(tie, spring, attachment) for every spring between a cloth and another body that is not broken. Two
/// cloths step together (tied_cloths.hpp).
template <class AnyWorld, class Visit>
void for_each_spring(const Exec& exec, const ClothBody& body, AnyWorld& world, const Visit& visit) {
  const CoupledSupport* support = cloth_support(world, body);
  if (!support) return;
  const int own = coupled_index(world, support->body);
  for (auto& attachment : world.coupling.attachments) {
    if (attachment.swept < 0 || attachment.ties.empty() ||
        cloth_point(attachment, attachment.ties[0]).body != own)
      continue;
    const int other = other_point(attachment, attachment.ties[0]).body;
    if (other >= 0 && coupled_body(world, other).kind == BodyKind::kCloth) continue;
    const std::vector<Vec3d> displacement =
        other < 0 ? std::vector<Vec3d>() : displacement_at_end(exec, world, other);
    for (auto& tie : attachment.ties) {
      if (tie.broken) continue;
      const contact::SurfacePoint& point = cloth_point(attachment, tie);
      const Vec3d target = point.rest + contact::displacement_of(other_point(attachment, tie), displacement);
      visit(tie,
            cloth::VertexSpring{.vertex = support->carrier[std::size_t(point.vertex.x)],
                                .target = Vec3(target),
                                .stiffness = Real(tie.stiffness),
                                .slack = Real(tie.slack)},
            attachment);
    }
  }
}

}  // namespace

std::vector<cloth::VertexSpring> attachment_springs(const Exec& exec, const ClothBody& body,
                                                    const World& world) {
  std::vector<cloth::VertexSpring> springs;
  for_each_spring(exec, body, world,
                  [&](const contact::Tie&, const cloth::VertexSpring& spring, const Attachment&) {
                    springs.push_back(spring);
                  });
  return springs;
}

void finish_attachment_springs(const Exec& exec, const ClothBody& body, World& world) {
  std::vector<Attachment*> read;
  for_each_spring(
      exec, body, world, [&](contact::Tie& tie, const cloth::VertexSpring& spring, Attachment& attachment) {
        const Vec3d force(cloth::spring_force(spring, body.state->x[std::size_t(spring.vertex)]).force);
        tie.force = attachment.swept == 0 ? force : -force;
        if (read.empty() || read.back() != &attachment) read.push_back(&attachment);
      });
  for (Attachment* attachment : read) contact::break_overloaded(attachment->ties);
}

Status check_cloth_attachment(const World& world, const std::string& where, const Attachment& attachment) {
  constexpr double kMost = 3.5;  // the leapfrog method is stable below 4, and the sum is a bound
  const int index = other_point(attachment, attachment.ties[0]).body;
  if (index < 0 || index >= first_support(world)) return Done{};
  // stiffness over inertia
  double ratio = 0;
  if (const RigidBody* rigid = rigid_body(world, index)) {
    if (rigid->model.is_fixed) return Done{};
    for (const contact::Tie& tie : attachment.ties)
      ratio += tie.stiffness * mobility(*rigid, other_point(attachment, tie).rest) * world.dt * world.dt;
  } else {
    const SfemBody& body = world.sfem_bodies[std::size_t(index)];
    if (!body.flight) return Done{};
    const double mass = std::accumulate(body.model.mass.begin(), body.model.mass.end(), 0.0);
    ratio = attachment.stiffness * world.dt * world.dt / mass;
  }
  if (ratio <= kMost) return Done{};
  return Error{
      fmt::format("{}: expected at most {:.3g} N/m between a cloth and {}, which moves freely, found "
                  "{:.3g}",
                  where, attachment.stiffness * kMost / ratio,
                  touched_body(world, coupled_body(world, index)).name, attachment.stiffness)};
}

void add_cloth_attachments(const World& world, BodyId id, ClothForces& forces) {
  if (world.coupling.attachments.empty() || (id.kind != BodyKind::kSfem && id.kind != BodyKind::kRigid))
    return;
  const int index = coupled_index(world, id);
  const std::vector<contact::VertexForce> pulled = swept_forces_on(world, index);
  forces.force.insert(forces.force.end(), pulled.begin(), pulled.end());
  // a body that moves freely bears the whole force at once: a lag would drive it
  if (id.kind == BodyKind::kSfem && !world.sfem_bodies[std::size_t(id.index)].flight)
    forces.mass += swept_stiffness_on(world, index) * world.dt * world.dt;
}

}  // namespace turgor
