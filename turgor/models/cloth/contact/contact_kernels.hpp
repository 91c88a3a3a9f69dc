// Kernels for host and device: vertex–vertex contacts, and the impulse iterations of all contacts. Each
// handles one pair, one contact or one vertex, in any order.
#pragma once

#include "turgor/core/atomic_max.hpp"
#include "turgor/models/cloth/contact/contact.hpp"
#include "turgor/models/cloth/contact/normal_cones.hpp"
#include "turgor/models/cloth/model/sheet_view.hpp"
#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

/// Search distance of a step: two vertices approach by at most twice the largest displacement. It is clamped
/// to `least` … 2 thicknesses.
inline Real reach_in_step(Real thickness, Real least, Real largest_speed, Real dt) {
  return thickness * std::clamp(1 + 2 * dt * largest_speed / thickness, least, Real(2));
}

/// Vertex pairs at the beginning of a step.
struct PairsView {
  ConstVectorsView x, v, change;
  ContactsView old;
  const int *excluded_begin, *excluded_item;  // Model::excluded
  ConesView cones;
  Real thickness, friction, dt;

  TURGOR_HD Group group(int i) const {
    const auto n = std::size_t(i);
    return {v[n], change[n], old.touches(i)};
  }
  TURGOR_HD bool are_excluded(int i, int j) const {
    for (int n = excluded_begin[i]; n < excluded_begin[i + 1]; n++)
      if (excluded_item[n] == j) return true;
    return false;
  }
  /// Tests vertices i < j and fills in their contact. False: they have no contact.
  TURGOR_HD bool touch(int i, const Group& mine, int j, Vec3 xj, ContactPhase phase, Contact& contact) const {
    // distance, normal and the same contact of the step before
    const Vec3 d = x[std::size_t(i)] - xj;
    const Real distance = norm(d);
    contact.vertex = {i, j, -1, -1}, contact.weight = {1, -1, 0, 0};
    contact.normal = distance > 0 ? d / distance : Vec3{0, 0, 1};
    const Contact* before = find_previous(old, contact);
    if (!forms_contact(contact.normal, before, phase, mine, group(j), distance, thickness, dt)) return false;
    if (are_excluded(i, j) || !cones.vertex_has(i, -d) || !cones.vertex_has(j, d)) return false;
    // gap and warm start
    contact.plane =
        cones.begin ? corrected_distance(before, phase, distance, thickness, thickness) : thickness;
    contact.gap = distance - thickness;
    contact.friction = friction;
    if (before)
      contact.impulse = before->impulse * before->warm_start,
      contact.friction_impulse = before->friction_impulse * before->warm_start;
    return true;
  }
};
inline ConesView cones_view(const Model& model, const State& state) {
  const NeighborLists& stars = model.large.stars;
  return {view(state.x), stars.begin.empty() ? nullptr : stars.begin.data(), stars.item.data()};
}
inline PairsView pairs_view(const Model& model, const State& state, double dt) {
  return {view(state.x),
          view(state.v),
          view(state.system.change),
          view(state.contacts),
          model.excluded.begin.data(),
          model.excluded.item.data(),
          cones_view(model, state),
          Real(model.params.collision.thickness),
          Real(model.params.collision.friction),
          Real(dt)};
}

TURGOR_HD inline Vec3 weighted_sum(const Contact& c, ConstVectorsView field) {
  Vec3 sum;
  for (std::size_t k = 0; k < 4; k++)
    if (c.vertex[k] >= 0) sum += field[std::size_t(c.vertex[k])] * c.weight[k];
  return sum;
}

TURGOR_HD inline void start_impulse(Contact& c) {
  c.projected_impulse = c.normal * c.impulse + c.friction_impulse, c.impulse_delta = {};
}

/// One Jacobi iteration of a contact impulse. The constraint is u_n + max(g, 0)/dt ≥ 0 with the velocity u
/// relative to the obstacle and the gap g; the projection onto the admissible set is
///
///   P_n ← max(0, P_n − m (u_n + max(g, 0)/dt)),     P_t ← P_t − m u_t, scaled to |P_t| ≤ μ P_n
///
/// with m the effective mass. `beyond` times the step from the last projected impulse is added
/// (overrelaxation). Returns the speed that the constraint was violated by [m/s].
TURGOR_HD inline Real update_impulse(Contact& c, ConstVectorsView v, Real dt, Real relaxation) {
  // normal impulse
  const Vec3 u = weighted_sum(c, v) - c.obstacle_velocity;
  const Real un = dot(u, c.normal), closing = un + larger(c.gap, 0) / dt;
  const Real impulse = larger(c.impulse - closing * c.mass, 0);
  // friction impulse within Coulomb's cone
  Vec3 friction_impulse = c.friction_impulse - (u - c.normal * un) * c.mass;
  friction_impulse -= c.normal * dot(friction_impulse, c.normal);
  const Real size = norm(friction_impulse), limit = c.friction * impulse;
  if (size > limit) friction_impulse *= limit / size;
  // overrelaxation
  const Vec3 before = c.normal * c.impulse + c.friction_impulse,
             projected = c.normal * impulse + friction_impulse;
  const Vec3 next = projected + (projected - c.projected_impulse) * relaxation;
  const Real violation = c.mass > 0 ? norm(projected - before) / c.mass : 0;
  c.projected_impulse = projected, c.impulse_delta = next - before;
  c.impulse = dot(next, c.normal), c.friction_impulse = next - c.normal * c.impulse;
  return violation;
}

/// One Jacobi iteration of a position impulse, for the constraint n·Σ w x ≥ plane. Returns the violation [m].
TURGOR_HD inline Real update_position_impulse(Contact& c, ConstVectorsView x, Real dt, Real relaxation) {
  Vec3 at = weighted_sum(c, x), normal = c.normal;
  Real distance = dot(at, normal);
  if (c.obstacle < 0 && c.vertex[2] < 0 &&
      distance > 0) {  // two vertices: the normal follows their current direction
    distance = norm(at);
    normal = at / distance;
  }
  // violation of the constraint
  const Real penetration = c.plane + dt * dot(c.obstacle_velocity, c.normal) - distance;
  // projection and overrelaxation
  const Real projected = larger(c.position_impulse + penetration * c.mass, 0);
  const Real next = projected + relaxation * (projected - c.projected_position_impulse);
  c.impulse_delta = normal * (next - c.position_impulse);
  c.position_impulse = next, c.projected_position_impulse = projected;
  return penetration > 0 && c.mass > 0 ? penetration : 0;
}

/// Effective mass of a contact, 1 / Σ n_v w² / m_v, with each vertex split into its n_v contacts [mass
/// splitting: Tonge et al. 2012]. If one vertex is held, a free vertex with a small weight could not make up
/// for all, so w replaces w².
TURGOR_HD inline Real contact_mass(const Contact& c, const int* begin, const Real* free_mass) {
  bool is_held = false;
  for (std::size_t k = 0; k < 4; k++) is_held = is_held || (c.vertex[k] >= 0 && free_mass[c.vertex[k]] == 0);
  Real sum = 0;
  for (std::size_t k = 0; k < 4; k++) {
    const int v = c.vertex[k];
    if (v < 0) continue;
    const Real w = c.weight[k] < 0 ? -c.weight[k] : c.weight[k];
    const Real share = Real(begin[v + 1] - begin[v]) * (is_held ? w : w * w);
    if (free_mass[v] > 0) sum += share / free_mass[v];
  }
  return sum > 0 ? 1 / sum : 0;
}

/// Sets the warm start of the next step. Impulses that move their vertices by more than a few thicknesses
/// come from contradictory holds and would grow from step to step, so they are cut.
TURGOR_HD inline void set_warm_start(Contact& c, const Real* free_mass, Real largest_speed_change) {
  Real mass = 0;
  for (std::size_t k = 0; k < 4; k++)
    if (c.vertex[k] >= 0) mass += free_mass[c.vertex[k]];
  const Real limit = mass * largest_speed_change;
  c.warm_start = c.impulse > limit && !c.is_implicit ? limit / c.impulse : 1;
}
inline Real largest_warm_start(const Collision& params, double dt) {
  constexpr double kWarmStartThicknesses = 4;
  return Real(kWarmStartThicknesses * params.thickness / dt);
}

/// Adds the impulse deltas of its contacts to a vertex: velocity, or position for position impulses.
struct ImpulseDelta {
  ContactsView contacts;
  const Real* free_mass;
  VectorsView field;

  TURGOR_HD void operator()(std::size_t vertex) const {
    if (free_mass[vertex] == 0) return;
    Vec3 sum;
    for (int m = contacts.begin[vertex]; m < contacts.begin[vertex + 1]; m++) {
      const auto item = std::size_t(contacts.item[m]);
      const Contact& c = contacts.list[item / 4];
      sum += c.impulse_delta * c.weight[item % 4];
    }
    field.add(vertex, sum / free_mass[vertex]);
  }
};

/// Overrelaxation of an iteration; the last one has none.
TURGOR_HD inline Real overrelaxation(int iteration) { return Real(iteration - 1) / Real(iteration + 2); }
/// Violations below which the iterations stop [m/s] [m].
inline Real velocity_tolerance(const Collision& params, double dt) {
  return Real(0.002 * params.thickness / dt);
}
inline Real position_tolerance(const Collision& params) { return Real(0.002 * params.thickness); }

}  // namespace turgor::cloth
