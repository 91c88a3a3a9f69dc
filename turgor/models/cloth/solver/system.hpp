// The linear system of a step, W Δv = h f̃ with W = M − s J, and its solvers. W is never stored: a spring's
// block is along · d dᵀ + across · I with d between its vertices, so that two numbers and the places make it.
#pragma once

#include "turgor/models/cloth/model/cloth.hpp"

namespace turgor::cloth {

/// Forces and the matrix at the places and velocities of the state. Impulses of the step before are among the
/// forces, and held vertices have the change that leads to their goals.
void assemble(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt);

/// Solves for System::change, as Solver says.
void solve_change(const Exec& exec, const Model& model, State& state, double dt);

/// Solves once more, around where that leads, while it turns edges far and obstacles stop the sheet.
void solve_what_turned(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt);
/// Of a system that was assembled again: what contacts of implicit_contact.hpp add to its diagonal.
void stiffen_bearing(State& state);
/// By conjugate gradients, until no contact opens, closes or gives way any more; from the present change on.
void solve_with_bearing(const Exec& exec, const Model& model, State& state, double dt);

/// Parts of the solvers, for tests and benches. One sweep leads `change` to
/// before + omega (W_ii⁻¹ (force + s Σ J_ij change_j) − before).
/// Gives every part that nothing holds the velocity that the total of a force gives it as a whole.
void move_free_parts(const Exec& exec, const Model& model, State& state, const Vectors& force, double dt);
void start_change(const Exec& exec, const Model& model, State& state, double dt);
void sweep(const Exec& exec, const Model& model, State& state, Real omega);
void solve_by_sweeps(const Exec& exec, const Model& model, State& state, Method method, int sweeps);
/// When conjugate gradients stop, and whether blocks of vertices help them.
struct Stop {
  int iterations = 100;  // at most
  double residual = 0;   // |force − W change| / |force| that is small enough [1]
  bool blocks = false;
};
/// Sets System::iterations and residual.
void solve_by_conjugate_gradients(const Exec& exec, const Model& model, State& state, const Stop& stop);

/// |force − W change| / |force| over the free vertices. The system was assembled to measure it.
double residual(const Exec& exec, const Model& model, State& state);

}  // namespace turgor::cloth
