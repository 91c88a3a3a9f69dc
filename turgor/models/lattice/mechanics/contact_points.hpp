// Contacts at points embedded in cells. The force of a contact acts on the corners of its cell by their
// weights in the displacement of the point. In a cut cell, corners are those of a fragment, nodes or virtual
// nodes. The stiffness of one corner, which leads, sets the penalty.
//
// A sweep takes each contact at the displacements with which it begins. Every corner has the share w of the
// force there, and |w| Σ|w| of the stiffness. These shares bound the stiffness between corners (w w') by the
// sums of its rows, so that a sweep never raises the energy. The force is updated after the sweep. If it were
// updated between the corners, or if each corner closed the gap alone, the result of a few sweeps would
// depend on the order of the corners, and press the tissue off the tool.
#pragma once

#include <span>
#include <vector>

#include "turgor/models/lattice/mechanics/cut_elements.hpp"
#include "turgor/models/lattice/mechanics/node_contact.hpp"
#include "turgor/models/lattice/mechanics/point_springs.hpp"

namespace turgor::lattice {

/// Stiffness of a contact at a point over that of its leading corner, as kContactStiffness of a node. Forces
/// on finer cells do not come to rest from about 10 on; between 0.3 and 3 they hardly differ.
constexpr Real kPointContactStiffness = 3;

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
  Real weight = 0;  // w in the displacement of the point; negative where the point lies outside its cell
  Real share = 0;   // of the stiffness: |w| Σ |w|
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

  Vec3 u(std::size_t contact) const {
    return displacement(points.at[contact], [this](int corner) { return view.u(corner); });
  }
  /// Penalty stiffness of a contact. `own`: stiffness of its leading corner with its inertia [N/m].
  Real penalty(std::size_t contact, Real own) const;
  /// Forces and stiffnesses of the contacts at the present displacements.
  std::vector<ContactForce> forces() const;
  /// Updates the forces of the contacts after a sweep.
  void update_forces() const;
};

/// Adds the shares of the contacts of one corner to its system. `terms`: of the corner; `forces`: of all
/// contacts, before the sweep.
void add_contacts(std::span<const ContactTerm> terms, std::span<const NodeContact> contacts,
                  std::span<const ContactForce> forces, NodeSystem& s);

}  // namespace turgor::lattice
