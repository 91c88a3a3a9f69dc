#include "turgor/models/lattice/model/whole_motion.hpp"

#include "turgor/core/assert.hpp"

namespace turgor::lattice {

namespace {

/// visit(slot, mass) for every node that moves.
template <class Visit>
void for_each_moving_node(const Model& model, const State& state, const Visit& visit) {
  const auto& inverse_mass = model.anatomy.inverse_mass;
  for (std::size_t s = 0; s < inverse_mass.size(); s++)
    if (inverse_mass[s] > 0 && !state.cuts.removed[s]) visit(int(s), 1 / double(inverse_mass[s]));
}

}  // namespace

Vec3d node_position(const Model& model, const State& state, int slot) {
  const Lattice& l = model.anatomy.lattice;
  return Vec3d(rest_position(l, slot_node(l, slot))) + Vec3d(state.motion.u[std::size_t(slot)]);
}

// Momentum P = Σ m v, angular momentum L = Σ m r × v about the center, inertia J = Σ m (r·r I − r rᵀ).
WholeMotion whole_motion(const Model& model, const State& state) {
  WholeMotion whole;
  Vec3d momentum;
  for_each_moving_node(model, state, [&](int slot, double mass) {
    whole.mass += mass;
    whole.center += node_position(model, state, slot) * mass;
    momentum += Vec3d(state.motion.v[std::size_t(slot)]) * mass;
  });
  if (!(whole.mass > 0)) return whole;
  whole.center = whole.center / whole.mass, whole.velocity = momentum / whole.mass;
  // rotation
  Vec3d angular;
  Mat3d inertia{{{}, {}, {}}};
  for_each_moving_node(model, state, [&](int slot, double mass) {
    const Vec3d r = node_position(model, state, slot) - whole.center;
    angular += cross(r, Vec3d(state.motion.v[std::size_t(slot)])) * mass;
    for (int axis = 0; axis < 3; axis++) {
      inertia.column[axis][axis] += mass * dot(r, r);
      inertia.column[axis] -= r * (mass * r[axis]);
    }
  });
  if (determinant(inertia) > 0) whole.inverse_inertia = inverse(inertia);
  whole.spin = whole.inverse_inertia * angular;
  return whole;
}

void add_velocity(const Model& model, Vec3d center, Vec3d velocity, Vec3d spin, State& state) {
  for_each_moving_node(model, state, [&](int slot, double) {
    const Vec3d by = velocity + cross(spin, node_position(model, state, slot) - center);
    const auto s = std::size_t(slot);
    state.motion.v.set(s, state.motion.v[s] + Vec3(by));
  });
}

}  // namespace turgor::lattice
