// Linear system of a step, W Δv = h f̃ with W = M (1 + h α) − s J, and its solvers. W is never stored: the
// block of a spring is along · d dᵀ + across · I with d the vector between its vertices, so two numbers per
// half spring suffice.
#pragma once

#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

/// Assembles forces and matrix at the positions and velocities of the state. With sweeps, the forces include
/// the contact impulses of the step before. Held vertices get the velocity change that reaches their goals.
void assemble(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt);

/// Repeats the solution around its result while edges rotate far and obstacles stop the sheet
/// (relinearization.cpp).
void relinearize(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt);
/// Adds the implicit contacts to the diagonal blocks of a system that was assembled again.
void add_contacts_to_diagonal(State& state);
/// Solves by conjugate gradients, starting from System::change, until the active set of implicit contacts is
/// stable.
void solve_with_implicit_contacts(const Exec& exec, const Model& model, State& state, double dt);

/// Adds to each component without held vertices the rigid velocity change that the total of `force` gives it.
void move_free_components(const Exec& exec, const Model& model, State& state, const Vectors& force,
                          double dt);
/// Initial guess: the total force on free components, the goals of held vertices.
void start_change(const Exec& exec, const Model& model, State& state, double dt);
/// One sweep: change ← previous + omega (W_ii⁻¹ (force + s Σ J_ij change_j) − previous).
void sweep(const Exec& exec, const Model& model, State& state, Real omega);
void solve_by_sweeps(const Exec& exec, const Model& model, State& state, Method method, int sweeps);
/// Stop criterion of conjugate gradients, and their preconditioner.
struct StopCriterion {
  int iterations = 100;  // at most
  double residual = 0;   // sufficient |force − W change| / |force| [1]
  bool two_level = false;
  bool by_diagonal = false;  // residual and force are measured with the inverse diagonal
};
/// Preconditioned conjugate gradients. Sets System::iterations and System::residual.
void solve_by_conjugate_gradients(const Exec& exec, const Model& model, State& state,
                                  const StopCriterion& stop);

/// |force − W change| / |force| over the free vertices. The system must be assembled with
/// Inputs::measure_residual.
double residual(const Exec& exec, const Model& model, State& state);

}  // namespace turgor::cloth
