// Mass of a whole deformed CT against that of the CT at rest. Unlike the mass of the tissue's voxels alone,
// it includes the partial volume, which moves with the skin and bears the mass that the scanner blurred out.
#pragma once

#include "turgor/models/lattice/resample/resample.hpp"

namespace turgor::lattice {

/// Relative error of Σ (HU + 1000) · volume over a deformed CT with its surroundings: its difference from the
/// body at rest, divided by the body's mass. 0 for a body without mass. `rest`: no displacements, and the
/// cuts of the deformed body.
double image_mass_error(const Exec& exec, const Model& model, const State& rest, const CtVolume& ct,
                        const CtVolume& deformed);

}  // namespace turgor::lattice
