// Contacts in the system of one node, by the augmented Lagrangian: every sweep sees a penalty around the
// force that the sweep before found, so that the force converges to the one that just keeps the node out,
// whatever the penalty's stiffness. [Hestenes 1969; Giles, Diaz and Yuksel 2025 for descent]
#pragma once

#include <algorithm>
#include <span>

#include "turgor/models/lattice/mechanics/element_energies.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

/// How many times as stiff as the node itself a contact is. More finds a contact's force in fewer sweeps,
/// less lets neighbours in contact share theirs sooner.
constexpr Real kContactStiffness = 10;

/// What a contact does to its node at one displacement.
struct ContactForce {
  Vec3 force;       // on the node [N]
  Real along = 0;   // stiffness along the normal [N/m]
  Real across = 0;  // and across it [N/m]
};

/// Never pulling, and friction inside its cone: the trial force of a penalty, projected. With `touches` the
/// normal part stays linear, for the node's own system: there it may pull, so that what was pushed too far
/// comes back.
TURGOR_HD inline ContactForce contact_force(const NodeContact& c, Vec3 u, bool touches = false) {
  const Vec3 trial = c.force + (c.target - u) * c.stiffness;
  if (c.is_held) return {trial, c.stiffness, c.stiffness};
  const Real pressing = dot(trial, c.normal);
  if (!(pressing > 0) && !touches) return {};
  const Vec3 rubbing = trial - c.normal * pressing;
  const Real most = c.friction * positive(pressing), length = norm(rubbing);
  const Real part = length > most ? most / length : 1;
  return {c.normal * pressing + rubbing * part, c.stiffness, c.stiffness * part};
}

/// Did it push in the last sweep?
TURGOR_HD inline bool bears(const NodeContact& c) { return dot(c.force, c.normal) > 0; }
/// Does the node touch in this sweep: because it did in the last one, or because it would go in without the
/// contact?
TURGOR_HD inline bool touches(const NodeContact& c, Vec3 u_without) {
  return bears(c) || dot(c.target - u_without, c.normal) > 0;
}

/// Of the place that touches [m].
TURGOR_HD inline Vec3 contact_displacement(const NodeContact& c, const NodeArrays& n) {
  const Vec3 own = n.u(c.slot);
  return c.other < 0 ? own : (own + n.u(c.other)) * Real(0.5);
}

/// Adds the contacts of one node to its system. They are equally stiff, and share what one alone would have.
/// Whether one alone touches is told by where the node would go without it; beside others, by whether it
/// bears, for what those hold out it would pull back in. `mobility`: h² w [m/N].
TURGOR_HD inline void press_node(std::span<NodeContact> touched, const NodeArrays& n, Vec3 to_inertial,
                                 Real mobility, NodeSystem& s) {
  const Real share = kContactStiffness / Real(touched.size());
  const Real stiffness = share * ((s.xx + s.yy + s.zz) / 3 + 1 / mobility);
  const Vec3 without = newton_step(s, to_inertial, mobility);
  for (NodeContact& c : touched) {
    c.stiffness = stiffness;
    const Real part = c.other < 0 ? Real(1) : Real(0.5);  // of the node's step that the place goes along
    const Vec3 u = contact_displacement(c, n);
    const bool is_allocated = touched.size() == 1 ? touches(c, u + without * part) : bears(c);
    const ContactForce pushed = contact_force(c, u, is_allocated);
    s.f += pushed.force;
    add_outer(s, c.normal, (pushed.along - pushed.across) * part);
    add_isotropic(s, pushed.across * part);
  }
}

/// The contacts of the nodes of [slot, slot + count).
inline std::span<NodeContact> contacts_of(std::span<NodeContact> all, int slot, int count) {
  const auto at = [&](int s) {
    return std::lower_bound(all.begin(), all.end(), s,
                            [](const NodeContact& c, int v) { return c.slot < v; });
  };
  return all.empty() ? all : std::span<NodeContact>(at(slot), at(slot + count));
}

}  // namespace turgor::lattice
