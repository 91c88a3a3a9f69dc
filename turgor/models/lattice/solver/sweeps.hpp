// Phases of a step on the host: predictor, sweeps of PBD or VBD, velocities. step_sequence.hpp has their
// order; tests and benches call them one by one.
#pragma once

#include "turgor/models/lattice/model/inputs.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

/// Rows that a sweep leaves out (calm_rows.hpp).
struct CalmRows;

/// Adds loads to velocities: v += h w f. The sweeps need no further treatment of loads.
void add_loads(const Model& model, State& state, const Inputs& inputs, double dt);
/// Stores u in u_before and moves u to the starting point of the sweeps. For PBD and for bodies without fixed
/// nodes it is y = u + h v + h² g. Other bodies start without h² g, because few sweeps cannot carry weight to
/// the fixed nodes: it would invert cells, and springs do not recover from that.
void move_to_start(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt);
/// Both in the order of the method. PBD takes forces only through the starting point, so loads come first.
/// VBD has them in its energy and starts without; a large load on a light node would invert cells.
void predict(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt);
/// One PBD sweep over springs, volumes and skin. [Müller et al. 2007; STC]
void sweep_pbd(const Exec& exec, const Model& model, State& state, const HaloExchange* halo = nullptr);
/// One VBD sweep: each node takes one Newton step. [Chen et al. 2024] Solid tissue runs the second half of
/// its sweeps backward. The remaining error is then a symmetric part of the initial one, between none and
/// all, and never feeds the motion that inertia carries on. With forward sweeps only, it does from ν = 0.45
/// on. `calm` leaves out the calm rows of a body that sleeps; null: all rows that are awake are swept.
void sweep_vbd(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt,
               Order order = Order::kForward, CalmRows* calm = nullptr);
/// Colored sweeps of sweep_pbd and sweep_vbd, with any run (core/run.hpp).
template <class Run>
void sweep_pbd_by_colors(const Run& run, const Model& model, State& state);
template <class Run>
void sweep_vbd_by_colors(const Run& run, const Model& model, State& state, const Inputs& inputs, double dt,
                         Order order = Order::kForward, CalmRows* calm = nullptr);

/// Computes velocities (u − u_before)/h with damping. Restores the last state if a value is not finite.
StepReport finish(const Exec& exec, const Model& model, State& state, double dt,
                  const HaloExchange* halo = nullptr);

/// Gradient of the energy that implicit Euler minimizes, between predict and finish.
Residual measure_residual(const Exec& exec, const Model& model, const State& state, const Inputs& inputs,
                          double dt);
/// Gravity along the axes of the lattice [m/s²].
Vec3 lattice_gravity(const Model& model, const Inputs& inputs);

}  // namespace turgor::lattice
