// Stiffness of a whole lattice body, scaled after it was built.
#pragma once

#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

/// Multiplies the moduli of a model's springs and cells by `factor` > 0.
void scale_moduli(double factor, Model& model);

/// Multiplies every modulus of the tissue by `factor` > 0: springs, cells, cut cells and viscous stresses.
/// The skin and its balance with the tissue in the CT stay. For VBD, whose model is not on a device.
void scale_stiffness(double factor, Model& model, State& state);

}  // namespace turgor::lattice
