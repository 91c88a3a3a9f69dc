// Displacement field outside the deformed body, for programs that warp the CT with it. Partial volume moves
// with the nearest skin, as in the deformed CT, and voxels that the body left point to air.
#pragma once

#include <cstdint>
#include <span>

#include "turgor/core/exec.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

/// Fills the voxels that no tissue covers (`covered` 0). Voxels that the body and its blur never reached keep
/// a displacement of zero.
void fill_warp_outside(const Exec& exec, const Model& model, std::span<const std::uint8_t> covered,
                       VectorVolume& field);

}  // namespace turgor::lattice
