// Obstacles that bear a cloth: their contacts are solved together with the sheet, so that what holds a vertex
// up is felt in all of it in the same step. Each has an impulse that is kept from step to step and a
// stiffness in the matrix that makes up for what the impulse lacks [augmented Lagrangian: Alart, Curnier
// 1991]. Equations: docs/models/cloth.md.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "turgor/models/cloth/contact/contact.hpp"

namespace turgor::cloth {

/// How a contact answers velocities in the matrix of a step.
struct ImplicitContact {
  Real normal_stiffness = 0;      // along its normal [kg]; 0 = it is open
  Real tangential_stiffness = 0;  // across it, of friction [kg]
  Real stiff = 0;                 // what `firm` is when it is closed [kg]
  Real stick = 0;                 // what `grip` is when it sticks [kg]
  Vec3 held;                      // friction that it has without moving [N·s]
  Vec3 load;                      // impulse that it gives where velocities do not change [N·s]
  Real out = 0;  // of what is pressed between two obstacles: how fast it is led out of one of them [m/s]
};

struct ImplicitContacts {
  Contacts contacts;                           // with obstacles alone
  std::vector<ImplicitContact> answer;         // of each
  std::vector<std::array<double, 6>> inverse;  // diagonal blocks of touched vertices without contacts [1/kg]

  /// Any of the sixteen vertices from i on?
  bool touches(std::size_t i) const {
    const auto& begin = contacts.begin;
    return !begin.empty() && i + 1 < begin.size() && begin[i] < begin[std::min(i + 16, begin.size() - 1)];
  }
};

/// Contacts that the step may close, with the impulses of the step before, and their answers. The system was
/// assembled.
void find_implicit_contacts(const Exec& exec, const Model& model, State& state, const Inputs& inputs,
                            double dt);
/// Sets impulses to what the latest solution asked of them, and looks which contacts are open, stick or
/// slide. True: some are otherwise than they were solved, or gave way too far.
bool update_active_set(const Model& model, State& state, double dt);

/// What contacts add to force − W a, of the vertices from i on; without their loads, to −W a.
Lanes3 implicit_contact_terms(const State& state, const Vectors& a, bool with_loads, std::size_t i);

}  // namespace turgor::cloth
