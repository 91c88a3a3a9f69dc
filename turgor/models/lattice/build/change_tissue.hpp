// Laws of a lattice body, changed after it was built: moduli, stiffening, fibers, layers, relaxation. Nodes,
// labels, cuts, positions and velocities stay.
#pragma once

#include "turgor/core/exec.hpp"
#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

/// Values of `wanted` that a built body can take; the rest are those of the body: limits of CT values, law of
/// the body, partial cells, regions. The body's own values if the number or kind of its layers differs, or if
/// partial cells would get laws by cell (has_cell_laws).
TissueParams reachable_tissue(const TissueParams& wanted, const Model& model);

/// Gives the body the laws of `tissue` (reachable_tissue) and moduli times `scale`. The model is then that of
/// a body built with them; elements of cut cells scale with their cell. The history of viscous cells stays,
/// and begins at zero where the number of pairs changes. For VBD whose model is not on a device.
void change_tissue(const Exec& exec, const TissueParams& tissue, double scale, Model& model, State& state);

}  // namespace turgor::lattice
