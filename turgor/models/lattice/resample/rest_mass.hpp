// Rest frame and rest mass of a body in its CT.
#pragma once

#include "turgor/core/exec.hpp"
#include "turgor/geometry/kuhn_raster.hpp"
#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

/// Rest frame in voxels of the CT that the body was built from.
RestFrame rest_frame(const Model& model, const Grid& ct);
/// Rest mass Σ (HU + 1000) · volume without removed tissue [HU m³]. It includes the same tetrahedra as the
/// resampling.
double rest_mass(const Exec& exec, const Model& model, const Cuts& cuts, const CtVolume& ct);

}  // namespace turgor::lattice
