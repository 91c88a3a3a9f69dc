// One step of a cloth: predictor, linear solution, contacts, motion, CCD.
#pragma once

#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

/// Result of a step. `residual` is that of the linear system relative to its right-hand side: |b − W Δv|/|b|.
struct StepReport {
  bool finite = true;      // false: the step was undone, and the cloth is at rest
  Real largest_speed = 0;  // [m/s]
  double residual = -1;    // -1: sweeps were used, and Inputs::measure_residual was not set [1]
  int contacts = 0;        // in Contacts::list
  int contact_iterations = 0;
  int iterations = 0;      // of conjugate gradients
  int in_impact_zone = 0;  // vertices of impact zones, whose motion CCD changed
};

/// Advances the state by `frame` [s]. If the result is not finite, the cloth keeps its positions and loses
/// its velocities.
StepReport step(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double frame);

}  // namespace turgor::cloth
