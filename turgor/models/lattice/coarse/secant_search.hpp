// Order of the phases in a coarse correction and the search for its step length, for a body on the host
// (coarse_correction.cpp) and for one on a device (coarse_kernels.hpp).
#pragma once

#include <algorithm>

#include "turgor/core/config.hpp"

namespace turgor::lattice {

/// Secant step length from the slopes at step lengths 0 and 1, at most 1.5. Returns 0 if `after` is not
/// finite.
TURGOR_HD inline double secant_step_length(double before, double after) {
  constexpr double kFarthest = 1.5;
  if (!(after - after == 0)) return 0;
  return before > after ? std::min(kFarthest, before / (before - after)) : kFarthest;
}

/// Search for the step length of a correction. A slope is restricted residual · correction.
struct SecantSearch {
  double slope = 0;        // before the correction [J]
  double step_length = 0;  // fraction of the correction that has been added after the next prolongation
  double change = 0;       // fraction that the next prolongation adds

  /// Begins with the full correction if it is a descent direction, otherwise with none.
  TURGOR_HD void begin(double before) { slope = before, step_length = change = before > 0 ? 1 : 0; }
  /// Continues from the full correction to the secant step length.
  TURGOR_HD void end(double after) {
    const double secant = slope > 0 ? secant_step_length(slope, after) : 0;
    change = secant - step_length, step_length = secant;
  }
};

/// One two-grid correction: a Newton step in the coarse space with a secant step length. `Body` has a member
/// function for each phase.
template <class Body>
void correct_two_grid(Body&& body) {
  body.restrict_residual();
  body.solve();
  body.begin_search();
  body.prolongate();
  body.restrict_residual();
  body.end_search();
  body.prolongate();
}

}  // namespace turgor::lattice
