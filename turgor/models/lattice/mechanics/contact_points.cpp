#include "turgor/models/lattice/mechanics/contact_points.hpp"

#include <algorithm>
#include <cmath>

namespace turgor::lattice {

int leading_corner(const CornerNodes& nodes, const EmbeddedPoint& point) {
  int leader = -1;
  Real most = 0;
  for (std::size_t c = 0; c < 8; c++)
    if (point.weight[c] > most && nodes.is_free(point.corner[c]))
      leader = point.corner[c], most = point.weight[c];
  return leader;
}

void make_terms(const CornerNodes& nodes, ContactPoints& points) {
  points.terms.clear(), points.concentration.clear();
  for (std::size_t p = 0; p < points.at.size(); p++) {
    const EmbeddedPoint& point = points.at[p];
    const std::size_t first = points.terms.size();
    Real squares = 0, weights = 0;
    for (std::size_t c = 0; c < 8; c++) {
      const Real w = point.weight[c];
      if (w == 0 || !nodes.is_free(point.corner[c])) continue;
      points.terms.push_back({.corner = point.corner[c], .contact = int(p), .weight = w});
      squares += w * w, weights += std::abs(w);
    }
    for (std::size_t t = first; t < points.terms.size(); t++)
      points.terms[t].share = std::abs(points.terms[t].weight) * weights;
    points.concentration.push_back(squares);
  }
  std::stable_sort(points.terms.begin(), points.terms.end(),
                   [](const ContactTerm& a, const ContactTerm& b) { return a.corner < b.corner; });
}

std::span<const ContactTerm> terms_of(const ContactPoints& points, int corner, int count) {
  const auto before = [](const ContactTerm& term, int c) { return term.corner < c; };
  const auto begin = std::lower_bound(points.terms.begin(), points.terms.end(), corner, before);
  return {begin, std::lower_bound(begin, points.terms.end(), corner + count, before)};
}

Real share_sum(const ContactPoints& points, std::span<const ContactTerm> terms) {
  Real sum = 0;
  for (const ContactTerm& term : terms)
    sum += term.weight * term.weight / points.concentration[std::size_t(term.contact)];
  return sum;
}

Real PointContacts::penalty(std::size_t contact, Real own) const {
  const Real shares = share_sum(points, terms_of(points, points.leader[contact], 1));
  return kPointContactStiffness * own / (shares * points.concentration[contact]);
}

std::vector<ContactForce> PointContacts::forces() const {
  std::vector<ContactForce> forces;
  for (std::size_t c = 0; c < contacts.size(); c++)
    forces.push_back(contact_force(contacts[c], u(c), was_active(contacts[c])));
  return forces;
}

void PointContacts::update_forces() const {
  for (std::size_t c = 0; c < contacts.size(); c++)
    contacts[c].force = contact_force(contacts[c], u(c)).force;
}

void add_contacts(std::span<const ContactTerm> terms, std::span<const NodeContact> contacts,
                  std::span<const ContactForce> forces, NodeSystem& s) {
  for (const ContactTerm& term : terms) {
    const ContactForce& contact = forces[std::size_t(term.contact)];
    s.f += contact.force * term.weight;
    add_outer(s, contacts[std::size_t(term.contact)].normal, (contact.along - contact.across) * term.share);
    add_isotropic(s, contact.across * term.share);
  }
}

}  // namespace turgor::lattice
