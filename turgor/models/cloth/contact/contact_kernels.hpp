// Contacts of vertices with vertices, and the impulses of all contacts: what is done to a pair, to a contact
// and to a vertex, in any order, on a CPU and on a GPU.
#pragma once

#include "turgor/core/atomic_max.hpp"
#include "turgor/models/cloth/device/sheet_view.hpp"
#include "turgor/models/cloth/model/cloth.hpp"

namespace turgor::cloth {

/// Two vertices can come as much nearer in a step as both of them move: as far is looked, within bounds.
inline Real reach_in_step(Real thickness, Real least, Real largest_speed, Real dt) {
  return thickness * std::clamp(1 + 2 * dt * largest_speed / thickness, least, Real(2));
}

/// Pairs of vertices before a step moves them.
struct PairsView {
  ConstVectorsView x, v, change;
  ContactsView old;
  const int *near_begin, *near_item;  // Model::near
  Real thickness, friction, dt;

  TURGOR_HD Group group(int i) const {
    const auto n = std::size_t(i);
    return {v[n], change[n], old.touches(i)};
  }
  TURGOR_HD bool are_near_at_rest(int i, int j) const {
    for (int n = near_begin[i]; n < near_begin[i + 1]; n++)
      if (near_item[n] == j) return true;
    return false;
  }
  /// Vertices i < j: false, or the contact that is looked for.
  TURGOR_HD bool touch(int i, const Group& mine, int j, Vec3 xj, Look look, Contact& contact) const {
    const Vec3 d = x[std::size_t(i)] - xj;
    const Real distance = norm(d);
    contact.vertex = {i, j, -1, -1}, contact.weight = {1, -1, 0, 0};
    contact.normal = distance > 0 ? d / distance : Vec3{0, 0, 1};
    const Contact* before = find_old(old, contact);
    if (!is_wanted(contact.normal, before, look, mine, group(j), distance, thickness, dt)) return false;
    if (are_near_at_rest(i, j)) return false;
    contact.plane = thickness, contact.room = distance - thickness;
    contact.friction = friction;
    if (before)
      contact.impulse = before->impulse * before->warm_start,
      contact.friction_impulse = before->friction_impulse * before->warm_start;
    return true;
  }
};
inline PairsView pairs_view(const Model& model, const State& state, double dt) {
  return {view(state.x),
          view(state.v),
          view(state.system.change),
          view(state.contacts),
          model.near.begin.data(),
          model.near.item.data(),
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
  c.allowed = c.normal * c.impulse + c.friction_impulse, c.impulse_delta = {};
}

/// Finds the change of the impulse that stops the approach, and friction within Coulomb's cone; `beyond` of
/// the way that the iteration went is added to it. Returns how far velocities were from what is allowed
/// [m/s].
TURGOR_HD inline Real update_impulse(Contact& c, ConstVectorsView v, Real dt, Real beyond) {
  const Vec3 u = weighted_sum(c, v) - c.drift;
  const Real un = dot(u, c.normal), too_fast = un + larger(c.room, 0) / dt;
  const Real impulse = larger(c.impulse - too_fast * c.mass, 0);
  Vec3 friction_impulse = c.friction_impulse - (u - c.normal * un) * c.mass;
  friction_impulse -= c.normal * dot(friction_impulse, c.normal);
  const Real size = norm(friction_impulse), limit = c.friction * impulse;
  if (size > limit) friction_impulse *= limit / size;
  const Vec3 before = c.normal * c.impulse + c.friction_impulse,
             allowed = c.normal * impulse + friction_impulse;
  const Vec3 next = allowed + (allowed - c.allowed) * beyond;
  const Real far = c.mass > 0 ? norm(allowed - before) / c.mass : 0;
  c.allowed = allowed, c.impulse_delta = next - before;
  c.impulse = dot(next, c.normal), c.friction_impulse = next - c.normal * c.impulse;
  return far;
}

/// How far the weighted sum must move to have room. Returns what it lacked [m].
TURGOR_HD inline Real update_place(Contact& c, ConstVectorsView x, Real dt, Real beyond) {
  Vec3 at = weighted_sum(c, x), normal = c.normal;
  Real distance = dot(at, normal);
  if (c.obstacle < 0 && c.vertex[2] < 0 && distance > 0) {  // two vertices: the direction follows them
    distance = norm(at);
    normal = at / distance;
  }
  const Real lack = c.plane + dt * dot(c.drift, c.normal) - distance;
  const Real allowed = larger(c.position_impulse + lack * c.mass, 0);
  const Real next = allowed + beyond * (allowed - c.position_impulse_allowed);
  c.impulse_delta = normal * (next - c.position_impulse);
  c.position_impulse = next, c.position_impulse_allowed = allowed;
  return lack > 0 && c.mass > 0 ? lack : 0;
}

/// With each vertex split among its contacts. Beside held vertices, one that has little weight could not be
/// asked to make up for all: weights count once there, not squared.
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

/// What the next step begins with: an impulse that moves its vertices by more than a few thicknesses belongs
/// to a state that holds make impossible, and would grow from step to step.
TURGOR_HD inline void set_carry(Contact& c, const Real* free_mass, Real largest_change) {
  Real mass = 0;
  for (std::size_t k = 0; k < 4; k++)
    if (c.vertex[k] >= 0) mass += free_mass[c.vertex[k]];
  const Real limit = mass * largest_change;
  c.warm_start = c.impulse > limit && !c.is_implicit ? limit / c.impulse : 1;
}
inline Real largest_carried(const Collision& params, double dt) {
  constexpr double kCarriedThicknesses = 4;
  return Real(kCarriedThicknesses * params.thickness / dt);
}

/// Gives a vertex its share of the kicks.
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

/// How much farther than allowed an iteration goes, but for the last.
TURGOR_HD inline Real beyond_of(int iteration) { return Real(iteration - 1) / Real(iteration + 2); }
/// Velocities and places are near enough from here on [m/s] [m].
inline Real small_speed(const Collision& params, double dt) { return Real(0.002 * params.thickness / dt); }
inline Real small_way(const Collision& params) { return Real(0.002 * params.thickness); }

}  // namespace turgor::cloth
