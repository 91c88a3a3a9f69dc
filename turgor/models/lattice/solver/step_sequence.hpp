// Order of the phases in a step, for a body on the host (step.cpp) and for one on a device (pbd_kernels.hpp,
// vbd_kernels.hpp). `Body` has a member function for each phase.
#pragma once

#include "turgor/models/lattice/mechanics/solid_laws.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

/// Sweeps of a VBD step: SolverParams::sweeps, and one more where solid tissue that is nearly incompressible
/// has an odd number. As many backward as forward sweeps make the remaining error a symmetric part of the
/// initial one (sweeps.hpp). With one forward sweep more, a bar of ν = 0.49 that stands under a load swings
/// up within seconds at 5 sweeps, and one of 0.45 at 3; bars of 0.45 at 5, and of 0.499 at 6, rest for
/// minutes.
inline int vbd_sweeps(const Params& params) {
  const int sweeps = params.solver.sweeps;
  const double odd_at_rest = sweeps > 3 ? 0.45 : 0.44;  // largest ratio at which odd sweeps come to rest
  const bool rounds_up =
      params.tissue.law == TissueLaw::kSolid && largest_poisson(params.tissue) > odd_at_rest;
  return rounds_up ? sweeps + sweeps % 2 : sweeps;
}

/// Direction of a VBD sweep.
inline Order sweep_order(bool solid, int sweep, int sweeps) {
  return solid && 2 * sweep >= sweeps ? Order::kBackward : Order::kForward;
}
/// True for the first backward sweep.
inline bool is_first_backward_sweep(bool solid, int sweep, int sweeps) {
  return sweep > 0 && sweep_order(solid, sweep, sweeps) != sweep_order(solid, sweep - 1, sweeps);
}

/// One step of PBD: loads, starting point, sweeps, velocities. [Müller et al. 2007]
template <class Body>
void step_pbd(Body&& body, int sweeps) {
  body.add_loads();
  body.move_to_start();
  for (int sweep = 0; sweep < sweeps; sweep++) body.sweep();
  body.finish();
}

/// One step of VBD. The first coarse correction is before the first backward sweep, so only solid tissue has
/// it; the second one is after the last sweep. A body that alternates has every second sweep backward, and a
/// correction before each of these. [Chen et al. 2024]
template <class Body>
void step_vbd(Body&& body, bool solid, int sweeps) {
  body.move_to_start();
  body.add_loads();
  body.measure_residual_before();
  const bool alternates = solid && body.alternates();
  for (int sweep = 0; sweep < sweeps; sweep++) {
    const bool backward = alternates && sweep % 2 == 1;
    if (alternates ? backward : is_first_backward_sweep(solid, sweep, sweeps)) body.correct_between();
    body.sweep(alternates ? (backward ? Order::kBackward : Order::kForward)
                          : sweep_order(solid, sweep, sweeps));
  }
  body.correct_after();
  body.measure_residual_after();
  body.finish();
}

}  // namespace turgor::lattice
