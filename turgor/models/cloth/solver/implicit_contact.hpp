// Implicit contacts: contacts that are solved together with the sheet, so that a support acts on all of it in
// the same step. Each has an impulse that is kept between steps, and a stiffness in the matrix that corrects
// the impulse [augmented Lagrangian: Alart, Curnier 1991]. While closed, with gap speed limit u_min and
// stiffness k,
//
//   P = n (λ + k (u_min − n·u)),     λ ← P after a solution.
//
// Friction is lagged diffusivity [Kačanov]. Equations: docs/models/cloth.md.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "turgor/models/cloth/contact/contact.hpp"

namespace turgor::cloth {

/// Finds the contacts that the step may close, with impulses of the step before, and sets up their terms. The
/// system must be assembled. `collisions`: contacts of pairs that collided in earlier solutions of the step.
void find_implicit_contacts(const Exec& exec, const Model& model, State& state, const Inputs& inputs,
                            double dt, std::span<const Contact> collisions = {});
/// Updates impulses from the latest solution, and the active set: open, sticking or sliding. True: the set
/// changed, friction is wrong, or a contact penetrates too far.
bool update_active_set(const Model& model, State& state, double dt);

/// True if any contact is closed, and if any contact with an obstacle is.
bool any_closed(const ImplicitContacts& contacts);
bool presses_obstacle(const ImplicitContacts& contacts);

/// Sets Contact::impulse_delta to the impulse of each contact in force − W a; without loads, in −W a.
void find_impulses(const Exec& exec, State& state, const Vectors& a, bool with_loads);
/// Sum of the impulses of find_impulses at the sixteen vertices from i on.
Lanes3 implicit_contact_terms(const State& state, std::size_t i);

}  // namespace turgor::cloth
