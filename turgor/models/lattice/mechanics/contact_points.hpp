// Contacts at points embedded in cells. The force of a contact acts on the corners of its cell by their
// weights in the displacement of the point. In a cut cell, corners are those of a fragment, nodes or virtual
// nodes. One corner leads: its stiffness sets the penalty, and the force of the contact is updated after it
// has moved. Corners of a cell never move at the same time, so that the result does not depend on the number
// of threads.
#pragma once

#include <span>
#include <vector>

#include "turgor/models/lattice/mechanics/cut_elements.hpp"
#include "turgor/models/lattice/mechanics/node_contact.hpp"
#include "turgor/models/lattice/mechanics/point_springs.hpp"

namespace turgor::lattice {

/// Nodes of corners. The node of a virtual node is the one that it doubles.
struct CornerNodes {
  const Model& model;
  std::span<const int> virtual_slots;  // by virtual node

  int slot(int corner) const {
    const auto slots = int(model.anatomy.inverse_mass.size());
    return corner < slots ? corner : virtual_slots[std::size_t(corner - slots)];
  }
  bool is_free(int corner) const { return model.anatomy.inverse_mass[std::size_t(slot(corner))] > 0; }
};

/// Free corner of the point of a contact.
struct ContactTerm {
  int corner = 0;   // as in CutCellElement
  int contact = 0;  // index into Inputs::contacts
  Real weight = 0;  // in the displacement of the point
};

/// Points of Inputs::contacts. The slot of each contact is the node of its leading corner; `other` is unused.
struct ContactPoints {
  std::vector<EmbeddedPoint> at;    // by contact
  std::vector<int> leader;          // by contact: the leading corner
  std::vector<ContactTerm> terms;   // corners ascend
  std::vector<Real> concentration;  // by contact: Σ w² over the free corners
};

/// Corner that leads the contact at a point: the free one with the largest weight; -1 if none is free.
int leading_corner(const CornerNodes& nodes, const EmbeddedPoint& point);
/// Lists the free corners of all points.
void make_terms(const CornerNodes& nodes, ContactPoints& points);
/// Terms of the corners in [corner, corner + count).
std::span<const ContactTerm> terms_of(const ContactPoints& points, int corner, int count);
/// Sum of the shares w²/Σ w² of the contacts of one corner. `terms`: of the corner.
Real share_sum(const ContactPoints& points, std::span<const ContactTerm> terms);

/// Contacts of a step and their points.
struct PointContacts {
  std::span<NodeContact> contacts;
  const ContactPoints& points;
  const CutElementView& view;

  Vec3 u(const ContactTerm& term) const {
    return displacement(points.at[std::size_t(term.contact)], [this](int corner) { return view.u(corner); });
  }
  bool leads(const ContactTerm& term) const {
    return points.leader[std::size_t(term.contact)] == term.corner;
  }
  /// Adds the contacts of one corner to its system, as add_contacts does. `terms`: of the corner.
  void add(std::span<const ContactTerm> terms, Vec3 to_inertial, Real mobility, NodeSystem& s) const;
  /// Updates the forces of the contacts that these corners lead.
  void update_forces(std::span<const ContactTerm> terms) const;
};

}  // namespace turgor::lattice
