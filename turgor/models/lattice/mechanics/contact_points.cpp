#include "turgor/models/lattice/mechanics/contact_points.hpp"

#include <algorithm>

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
    Real sum = 0;
    for (std::size_t c = 0; c < 8; c++) {
      if (point.weight[c] == 0 || !nodes.is_free(point.corner[c])) continue;
      points.terms.push_back({point.corner[c], int(p), point.weight[c]});
      sum += point.weight[c] * point.weight[c];
    }
    points.concentration.push_back(sum);
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

void PointContacts::add(std::span<const ContactTerm> terms, Vec3 to_inertial, Real mobility,
                        NodeSystem& s) const {
  const Real own = (s.xx + s.yy + s.zz) / 3 + 1 / mobility;
  const Real stiffness = kContactStiffness * own / share_sum(points, terms);
  const Vec3 without = newton_step(s, to_inertial, mobility);
  for (const ContactTerm& term : terms) {
    NodeContact& c = contacts[std::size_t(term.contact)];
    if (leads(term)) c.stiffness = stiffness / points.concentration[std::size_t(term.contact)];
    // force of the contact at the present displacement
    const Vec3 at = u(term);
    const bool active = terms.size() == 1 ? is_active(c, at + without * term.weight) : was_active(c);
    const ContactForce contact = contact_force(c, at, active);
    // its share
    const Real w2 = term.weight * term.weight;
    s.f += contact.force * term.weight;
    add_outer(s, c.normal, (contact.along - contact.across) * w2);
    add_isotropic(s, contact.across * w2);
  }
}

void PointContacts::update_forces(std::span<const ContactTerm> terms) const {
  for (const ContactTerm& term : terms) {
    NodeContact& c = contacts[std::size_t(term.contact)];
    if (leads(term)) c.force = contact_force(c, u(term)).force;
  }
}

}  // namespace turgor::lattice
