// The parts of a step: predict, sweeps of one solver or the other, finish. step() strings them together;
// tests and benches look at them one by one.
#pragma once

#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

/// Remembers u and moves it to where the sweeps begin: y = u + h v + h² g for pbd and for bodies that nothing
/// holds. What is held begins without h² g, for few sweeps cannot carry it back. Loads become a part of v.
void predict(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt);
/// One sweep of projections over springs, volumes and skin. [Müller 2007; STC]
void sweep_pbd(const Exec& exec, const Model& model, State& state, const HaloExchange* halo = nullptr);
/// One sweep of vertex block descent: every node takes one Newton step. [Chen et al. 2024] Solid tissue takes
/// the second half of its sweeps backward: then what they leave of an error is a symmetric part of it,
/// between none and all, and never feeds the motion that inertia carries on. Forward sweeps alone do, from ν
/// = 0.45 on.
void sweep_vbd(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt,
               Order order = Order::kForward);
/// Which way a sweep of descent goes.
inline Order sweep_order(bool solid, int sweep, int sweeps) {
  return solid && 2 * sweep >= sweeps ? Order::kBackward : Order::kForward;
}
/// Is it the first that goes backward?
inline bool is_turn(bool solid, int sweep, int sweeps) {
  return sweep > 0 && sweep_order(solid, sweep, sweeps) != sweep_order(solid, sweep - 1, sweeps);
}
/// Velocities from the way gone, damped; or everything back if a number is not finite.
StepReport finish(const Exec& exec, const Model& model, State& state, double dt,
                  const HaloExchange* halo = nullptr);

/// The gradient of what implicit Euler minimises, between predict and finish.
Residual measure_residual(const Exec& exec, const Model& model, const State& state, const Inputs& inputs,
                          double dt);
/// That energy itself: ½ Σ m/h² |u − y|² + elastic [J], between predict and finish.
double step_energy(const Exec& exec, const Model& model, const State& state, const Inputs& inputs, double dt);

/// Gravity along the lattice's axes.
Vec3 lattice_gravity(const Model& model, const Inputs& inputs);

}  // namespace turgor::lattice
