// Contacts of one node by the augmented Lagrangian. Each sweep uses a penalty around the force of the
// previous sweep. The force converges to the one that just keeps the node outside, for any penalty stiffness.
// [Hestenes 1969; Giles, Diaz, Yuksel 2025 for VBD]
#pragma once

#include <algorithm>
#include <span>

#include "turgor/models/lattice/mechanics/element_energies.hpp"
#include "turgor/models/lattice/model/inputs.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

/// Stiffness of a contact over the stiffness of its node. A larger value finds the force in fewer sweeps; a
/// smaller one lets neighbors in contact share the load sooner.
constexpr Real kContactStiffness = 10;

/// Contact force and stiffness at one displacement.
struct ContactForce {
  Vec3 force;       // on the node [N]
  Real along = 0;   // stiffness along the normal [N/m]
  Real across = 0;  // stiffness across the normal [N/m]
};

/// Contact force: the trial force λ + k (target − u), projected to λ_n ≥ 0 and the friction cone |λ_t| ≤ μ
/// λ_n. `active` keeps the normal part linear for the system of the node itself. It may pull there, which
/// corrects an overshoot.
TURGOR_HD inline ContactForce contact_force(const NodeContact& c, Vec3 u, bool active = false) {
  // trial force
  const Vec3 trial = c.force + (c.target - u) * c.stiffness;
  if (c.is_held) return {trial, c.stiffness, c.stiffness};
  const Real normal_force = dot(trial, c.normal);
  // normal part
  if (!(normal_force > 0) && !active) return {};
  const Vec3 tangential = trial - c.normal * normal_force;
  // Coulomb cone
  const Real most = c.friction * positive(normal_force), length = norm(tangential);
  const Real cone_scale = length > most ? most / length : 1;
  return {c.normal * normal_force + tangential * cone_scale, c.stiffness, c.stiffness * cone_scale};
}

/// True if the contact pushed in the last sweep.
TURGOR_HD inline bool was_active(const NodeContact& c) { return dot(c.force, c.normal) > 0; }
/// True if the contact is active in this sweep: it pushed in the last one, or the node would penetrate
/// without it.
TURGOR_HD inline bool is_active(const NodeContact& c, Vec3 u_without) {
  return was_active(c) || dot(c.target - u_without, c.normal) > 0;
}

/// Displacement of the contact point [m].
TURGOR_HD inline Vec3 contact_displacement(const NodeContact& c, const NodeArrays& n) {
  const Vec3 own = n.u(c.slot);
  return c.other < 0 ? own : (own + n.u(c.other)) * Real(0.5);
}

/// Adds the contacts of one node to its system. They share the stiffness of a single contact. A single
/// contact is active if the node would penetrate without it. One of several is active only if it pushed
/// before: the others hold the node, and it would pull back. `mobility`: h² w [m/N].
TURGOR_HD inline void add_contacts(std::span<NodeContact> node_contacts, const NodeArrays& n,
                                   Vec3 to_inertial, Real mobility, NodeSystem& s) {
  const Real share = kContactStiffness / Real(node_contacts.size());
  const Real stiffness = share * ((s.xx + s.yy + s.zz) / 3 + 1 / mobility);
  const Vec3 without = newton_step(s, to_inertial, mobility);
  for (NodeContact& c : node_contacts) {
    c.stiffness = stiffness;
    const Real weight =
        c.other < 0 ? Real(1) : Real(0.5);  // displacement of the contact point over that of the node
    const Vec3 u = contact_displacement(c, n);
    const bool active = node_contacts.size() == 1 ? is_active(c, u + without * weight) : was_active(c);
    const ContactForce contact = contact_force(c, u, active);
    s.f += contact.force;
    add_outer(s, c.normal, (contact.along - contact.across) * weight);
    add_isotropic(s, contact.across * weight);
  }
}

/// Contact forces at the current displacements, after the nodes have moved.
TURGOR_HD inline void update_forces(std::span<NodeContact> contacts, const NodeArrays& n) {
  for (NodeContact& c : contacts) c.force = contact_force(c, contact_displacement(c, n)).force;
}

/// Contacts of the nodes in [slot, slot + count).
inline std::span<NodeContact> contacts_of(std::span<NodeContact> all, int slot, int count) {
  const auto at = [&](int s) {
    return std::lower_bound(all.begin(), all.end(), s,
                            [](const NodeContact& c, int v) { return c.slot < v; });
  };
  return all.empty() ? all : std::span<NodeContact>(at(slot), at(slot + count));
}

}  // namespace turgor::lattice
