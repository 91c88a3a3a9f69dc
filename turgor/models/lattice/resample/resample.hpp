// CT of the deformed body: every tetrahedron is rasterized into the output grid, and each voxel takes the
// CT's value at its own rest position. [STC 2.2; Gascon et al. 2013]
#pragma once

#include "turgor/core/exec.hpp"
#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

struct ResampleOptions {
  bool conserve_mass = false;     // divide the density (HU + 1000) by the local volume ratio
  bool keep_surroundings = true;  // false: air around the body, without the scanned table
};

struct ResampleReport {
  double seconds = 0;
  double mass_error = 0;   // relative error of Σ (HU + 1000) · volume over the voxels of tissue, output
                           // against input. It lacks the partial volume, which image_mass_error includes.
  long inverted_tets = 0;  // inverted tetrahedra, which are left out
  long overlaps = 0;       // voxels claimed by more than one tetrahedron; the first in lattice order has them
};

struct ResampledCt {
  CtVolume ct;
  ResampleReport report;
};

/// Grid with `size` samples over the same extent.
Grid resized(const Grid& grid, Int3 size);

/// Resamples the CT as it would be scanned now. Air within three voxels of the skin holds the scanner's blur
/// and moves with the skin. Voxels that the body or the blur left become air; voxels that they never reached
/// keep their value. `ct` is the CT that the body was built from.
ResampledCt resample_ct(const Exec& exec, const Model& model, const State& state, const CtVolume& ct,
                        const Grid& out, const ResampleOptions& options = {});
/// Displacement from each voxel to the rest position of its tissue, patient frame [m]; zero outside the body.
VectorVolume resample_displacement(const Exec& exec, const Model& model, const State& state, const Grid& out);
/// The same, continued outside the body (warp_outside.hpp): ITK's displacement field transform. A warp of the
/// CT with it is the deformed CT, except for tables and clothing that the body covers or leaves, and for the
/// noise of air.
VectorVolume resample_warp(const Exec& exec, const Model& model, const State& state, const Grid& out);
/// Volume ratio of each voxel, deformed over rest; 1 outside the body.
ScalarVolume resample_jacobian(const Exec& exec, const Model& model, const State& state, const Grid& out);

}  // namespace turgor::lattice
