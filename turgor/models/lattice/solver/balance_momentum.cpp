#include "turgor/models/lattice/solver/balance_momentum.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/mechanics/contact_points.hpp"
#include "turgor/models/lattice/model/whole_motion.hpp"
#include "turgor/models/lattice/solver/inertia.hpp"
#include "turgor/models/lattice/solver/sleep.hpp"

namespace turgor::lattice {

namespace {

/// Sum of the inertial forces m (y − u)/h² of all free nodes [N].
Vec3d inertial_force(const Model& model, const State& state, const Inputs& inputs, double dt) {
  const Inertia inertia(model, state, inputs, dt);
  Vec3d moment;  // Σ m (y − u)
  for (std::size_t s = 0; s < model.anatomy.inverse_mass.size(); s++)
    if (const int slot = int(s); inertia.moves(slot) > 0)
      moment += Vec3d(inertia(slot) - state.motion.u[s]) / double(model.anatomy.inverse_mass[s]);
  return moment / (dt * dt);
}

/// True if a row with free nodes sleeps: the body is calm, and the row keeps its displacement.
bool has_sleeping_row(const Model& model, const State& state) {
  if (!can_sleep(model) || state.sleep.awake.empty()) return false;
  for (std::size_t s = 0; s < model.anatomy.inverse_mass.size(); s++)
    if (model.anatomy.inverse_mass[s] > 0 && !state.sleep.awake[std::size_t(row_of(model, int(s)))])
      return true;
  return false;
}

/// visit(node, force) for the nodes on which the contacts act.
template <class Visit>
void for_each_contact_force(const Inputs& inputs, const Visit& visit) {
  for (std::size_t c = 0; c < inputs.contacts.size(); c++) {
    const NodeContact& contact = inputs.contacts[c];
    const Vec3d force(contact.force);
    if (inputs.points) {
      const EmbeddedPoint& at = inputs.points->at[c];
      for (std::size_t k = 0; k < at.corner.size(); k++)
        if (at.weight[k] != 0) visit(at.corner[k], force * double(at.weight[k]));
    } else if (contact.other >= 0) {
      visit(contact.slot, force * 0.5), visit(contact.other, force * 0.5);
    } else {
      visit(contact.slot, force);
    }
  }
}

/// Residual of the rotation, Σ r × m (y − u)/h² + Σ r × f about the center of mass, lattice frame [N m].
Vec3d unbalanced_torque(const Model& model, const State& state, const Inputs& inputs, double dt,
                        Vec3d center) {
  const Inertia inertia(model, state, inputs, dt);
  const auto arm = [&](int slot) { return node_position(model, state, slot) - center; };
  Vec3d moment;  // Σ r × m (y − u)
  for (std::size_t s = 0; s < model.anatomy.inverse_mass.size(); s++)
    if (const int slot = int(s); inertia.moves(slot) > 0)
      moment +=
          cross(arm(slot), Vec3d(inertia(slot) - state.motion.u[s])) / double(model.anatomy.inverse_mass[s]);
  Vec3d torque = moment / (dt * dt);
  for_each_contact_force(inputs, [&](int slot, Vec3d force) { torque += cross(arm(slot), force); });
  return torque;
}

constexpr double kMostTurn = 0.05;  // in a step: a larger one would strain the body [rad]

bool holds_a_node(std::span<const NodeContact> contacts) {
  return std::any_of(contacts.begin(), contacts.end(), [](const NodeContact& c) { return c.is_held; });
}

}  // namespace

Vec3d unbalanced_force(const Model& model, const State& state, const Inputs& inputs, double dt) {
  const Anatomy& anatomy = model.anatomy;
  TURGOR_CHECK(is_step_length(dt), "a step has a positive length");
  if (anatomy.free_nodes < anatomy.body_nodes || inputs.halo != nullptr || inputs.springs != nullptr)
    return {};
  if (holds_a_node(inputs.contacts) || has_sleeping_row(model, state)) return {};
  Vec3d residual = inertial_force(model, state, inputs, dt);
  for (const NodeContact& contact : inputs.contacts) residual += Vec3d(contact.force);
  return residual;
}

// A shift of the whole body by R h²/M leaves its strain as it is, and makes the residual R zero. So does a
// rotation by J⁻¹ T h² about the center, which is small. Corners of cut cells have no arm: cut bodies are
// shifted only.
void balance_momentum(const Model& model, State& state, const Inputs& inputs, double dt) {
  const Vec3d residual = unbalanced_force(model, state, inputs, dt);
  if (residual == Vec3d{}) return;
  const WholeMotion whole = whole_motion(model, state);
  const Vec3d shift = residual * (dt * dt / whole.mass);
  Motion& motion = state.motion;
  Vec3d turn;
  if (motion.virtual_u.empty()) {
    turn = whole.inverse_inertia * unbalanced_torque(model, state, inputs, dt, whole.center) * (dt * dt);
    turn = turn * std::min(1.0, kMostTurn / std::max(norm(turn), kMostTurn));
  }
  const auto& inverse_mass = model.anatomy.inverse_mass;
  for (std::size_t s = 0; s < inverse_mass.size(); s++)
    if (inverse_mass[s] > 0 && !state.cuts.removed[s]) {
      const Vec3d arm = node_position(model, state, int(s)) - whole.center;
      motion.u.set(s, motion.u[s] + Vec3(shift + cross(turn, arm)));
    }
  for (VirtualNodeDisplacement& virtual_node : motion.virtual_u) virtual_node.move(Vec3(shift));
}

}  // namespace turgor::lattice
