// Energies in double precision, computed directly from their definitions. Tests compare the sweeps with them.
#pragma once

#include "turgor/core/exec.hpp"
#include "turgor/models/lattice/model/inputs.hpp"

namespace turgor::lattice {

/// Elastic energy of springs, volumes, cells, skin and cut elements, including prestress [J].
double energy(const Exec& exec, const Model& model, const State& state);
/// Energy that implicit Euler minimizes, ½ Σ m/h² |u − y|² + elastic energy [J]. Valid between predict and
/// finish.
double step_energy(const Exec& exec, const Model& model, const State& state, const Inputs& inputs, double dt);

}  // namespace turgor::lattice
