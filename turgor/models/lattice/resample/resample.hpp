// The deformed body as a CT again: every tetrahedron is rasterised into the output grid, each voxel takes the
// original CT's value at its own rest position. [STC 2.2; Gascon et al. 2013]
#pragma once

#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

struct ResampleOptions {
  bool conserve_mass = false;     // divide the density (HU + 1000) by the local change of volume
  bool keep_surroundings = true;  // false: air around the body, where the table was scanned
};

struct ResampleReport {
  double seconds = 0;
  double mass_error = 0;  // relative error of Σ (HU + 1000) · volume over the body, output against input; of
                          // use where the output holds the whole body
  long folds = 0;     // tetrahedra turned inside out, left out
  long overlaps = 0;  // voxels that two parts of the body claim; the first in lattice order has them
};

struct ResampledCt {
  CtVolume ct;
  ResampleReport report;
};

/// The grid of the CT with `size` samples over the same extent.
Grid resized(const Grid& grid, Int3 size);

/// The CT as it would be scanned now. The air within three voxels of the skin, which it blurs into, goes with
/// it; voxels that body or blur left become air, and those that they never reached keep their value. `ct` is
/// the CT that the body was built from.
ResampledCt resample_ct(const Exec& exec, const Model& model, const State& state, const CtVolume& ct,
                        const Grid& out, const ResampleOptions& options = {});
/// For each voxel: where its tissue came from, minus where it is; patient frame [m]; zero outside the body.
/// This is what ITK calls a displacement field transform.
VectorVolume resample_displacement(const Exec& exec, const Model& model, const State& state, const Grid& out);
/// For each voxel: volume now over volume in the CT; 1 outside the body.
ScalarVolume resample_jacobian(const Exec& exec, const Model& model, const State& state, const Grid& out);

}  // namespace turgor::lattice
