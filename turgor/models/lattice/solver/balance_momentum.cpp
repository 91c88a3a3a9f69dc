#include "turgor/models/lattice/solver/balance_momentum.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
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

// A shift of the whole body by R h²/M leaves its strain as it is, and makes R zero.
void balance_momentum(const Model& model, State& state, const Inputs& inputs, double dt) {
  const Vec3d residual = unbalanced_force(model, state, inputs, dt);
  if (residual == Vec3d{}) return;
  const auto& inverse_mass = model.anatomy.inverse_mass;
  double mass = 0;
  for (std::size_t s = 0; s < inverse_mass.size(); s++)
    if (inverse_mass[s] > 0 && !state.cuts.removed[s]) mass += 1 / double(inverse_mass[s]);
  const Vec3 shift = Vec3(residual * (dt * dt / mass));
  Motion& motion = state.motion;
  for (std::size_t s = 0; s < inverse_mass.size(); s++)
    if (inverse_mass[s] > 0 && !state.cuts.removed[s]) motion.u.set(s, motion.u[s] + shift);
  for (VirtualNodeDisplacement& virtual_node : motion.virtual_u) virtual_node.move(shift);
}

}  // namespace turgor::lattice
