// The body in its CT: where its cells lie there, and what it weighs.
#pragma once

#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/resample/raster.hpp"

namespace turgor::lattice {

/// In voxels of the CT that the body was built from.
RestFrame rest_frame(const Model& model, const Grid& ct);
/// Σ (HU + 1000) · volume over the body in the CT, less what left it: the voxels of all tetrahedra that are
/// drawn [HU m³].
double rest_mass(const Exec& exec, const Model& model, const State& state, const CtVolume& ct);

}  // namespace turgor::lattice
