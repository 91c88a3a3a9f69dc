// Contacts of a cloth with itself and with obstacles. A contact keeps a weighted sum of up to four vertices
// on the positive side of a plane: two vertices, a vertex and a triangle, two edges, or a vertex or triangle
// and an obstacle. Impulses obey Coulomb's law; positions are corrected without velocity. The equations
// differ from [Kang 2004] as docs/models/cloth.md says.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/vec.hpp"
#include "turgor/models/cloth/contact/spatial_hash.hpp"
#include "turgor/models/cloth/model/contacts.hpp"
#include "turgor/models/cloth/model/mesh_tables.hpp"
#include "turgor/models/cloth/model/vectors.hpp"

namespace turgor::cloth {

struct Model;
struct State;
struct Inputs;

/// Finds the contacts of a step with its predicted velocities, and adds the implicit contacts of the
/// solution.
void find_contacts(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt);

/// Set of self-contacts to search for.
enum class ContactPhase : std::uint8_t {
  kPredicted,  // candidates before the solution, whose velocities are not known yet
  kActual      // contacts with the velocities of the step, except implicit ones
};

/// Finds all contacts of a step from x with the velocities v, by chunk of the cloth. Impulses start from
/// those of Contacts::list. Contacts with obstacles are included in kPredicted, and in kActual unless
/// conjugate gradients solve them implicitly.
void find_step_contacts(const Exec& exec, const Model& model, State& state, const Inputs& inputs,
                        ContactPhase phase, double dt, std::vector<std::vector<Contact>>& found);
/// Finds vertex–triangle and edge–edge contacts of large primitives, in large_chunks chunks.
void find_large_contacts(const Exec& exec, const Model& model, State& state, ContactPhase phase, Real reach,
                         double dt, std::span<std::vector<Contact>> found);
std::size_t large_chunks(const Model& model);
/// Finds contacts of pairs that CCD found in earlier steps, while they are nearer than the thickness.
void find_ccd_contacts(const Model& model, State& state, ContactPhase phase, double dt,
                       std::vector<Contact>& found);

/// Mean velocity `v` of a group of vertices, and the share `change` of it that this step added.
struct Group {
  Vec3 v, change;
  bool touches = false;
};
/// Possible approach of two groups in a step along the normal, which points to `a` [m]. Either both move,
/// or only one does since contacts stop the other. If neither touched anything in the step before, only the
/// velocity that this step added counts in the latter case.
TURGOR_HD inline Real approach(const Group& a, const Group& b, Vec3 normal, Real dt) {
  const Real va = -dot(a.v, normal), vb = dot(b.v, normal);
  const Real alone_a = a.touches || b.touches ? va : -dot(a.change, normal);
  const Real alone_b = a.touches || b.touches ? vb : dot(b.change, normal);
  return dt * std::max(va + vb, std::max(alone_a, alone_b));
}

/// Plain-pointer view of contacts for host and device.
struct ContactsView {
  const Contact* list;
  const int *begin, *item;  // `begin` is null without contacts

  TURGOR_HD bool touches(int vertex) const { return begin != nullptr && begin[vertex] < begin[vertex + 1]; }
};
inline ContactsView view(const Contacts& contacts) {
  return {contacts.list.data(), contacts.begin.empty() ? nullptr : contacts.begin.data(),
          contacts.item.data()};
}

constexpr Real kPredictionMargin = Real(0.3);  // margin of predicted contacts, relative to the thickness

/// Tests whether two groups at a distance form a contact. `old` is the same contact in the step before.
TURGOR_HD inline bool forms_contact(Vec3 normal, const Contact* old, ContactPhase phase, const Group& a,
                                    const Group& b, Real distance, Real thickness, Real dt) {
  if (phase == ContactPhase::kPredicted)
    return distance - dt * norm(a.v - b.v) < (1 + kPredictionMargin) * thickness || (old && old->impulse > 0);
  return distance - approach(a, b, normal, dt) < thickness || (old && old->impulse > 0);
}

/// Distance that positions are corrected to after a step [m]. A contact may be found late, with a
/// penetration, since its direction was not in the normal cones before. An implicit one is separated by a
/// twentieth of the thickness a step, which adds little elastic energy.
TURGOR_HD inline Real corrected_distance(const Contact* old, ContactPhase phase, Real distance, Real least,
                                         Real thickness) {
  constexpr Real kRate = Real(0.05);
  if (distance >= least || phase == ContactPhase::kActual) return least;
  const Real reached = old ? larger(old->plane + kRate * thickness, distance) : distance;
  return smaller(reached, least);
}

/// True for an actual contact that is implicit already (implicit_contact.hpp). Only its vertices and its
/// obstacle matter.
bool is_implicit_already(const State& state, const Contact& contact, ContactPhase phase);

/// Contact of the same vertices in the step before, or null.
TURGOR_HD inline const Contact* find_previous(const ContactsView& contacts, const Contact& wanted) {
  const int v = wanted.vertex[0];
  if (contacts.begin == nullptr) return nullptr;
  for (int n = contacts.begin[v]; n < contacts.begin[v + 1]; n++) {
    const Contact& old = contacts.list[contacts.item[n] / 4];
    bool same = old.obstacle == wanted.obstacle;
    for (std::size_t k = 0; k < 4; k++) same = same && old.vertex[k] == wanted.vertex[k];
    if (same) return &old;
  }
  return nullptr;
}
inline const Contact* find_previous(const Contacts& contacts, const Contact& wanted) {
  return find_previous(view(contacts), wanted);
}

/// Builds the contact list of each of `count` vertices from Contacts::list.
void list_by_vertex(int count, Contacts& contacts);
/// The same for the vertices of a model, with the effective masses.
void link_contacts(const Model& model, const State& state, Contacts& contacts);

/// Solves the contact impulses by projected Jacobi iterations: afterwards no contact closes faster than its
/// gap permits. Returns the number of iterations.
int solve_velocities(const Exec& exec, const Model& model, State& state, double dt);
/// Removes penetration by moving vertices, without changing velocities.
void solve_positions(const Exec& exec, const Model& model, State& state, double dt);

/// Impulse on the obstacle of a contact in the latest step [N·s].
inline Vec3d impulse_on_obstacle(const Contact& c) {
  return -Vec3d(c.normal * c.impulse + c.friction_impulse);
}

/// Position of a contact with an obstacle: weighted sum of its vertices [m].
Vec3d contact_position(const State& state, const Contact& c);

/// Total impulse on an obstacle in the latest step [N·s], and its moment about `center` [N·m·s].
struct ObstacleLoad {
  Vec3d impulse, moment;
};
ObstacleLoad obstacle_load(const State& state, int obstacle, Vec3d center);

}  // namespace turgor::cloth
