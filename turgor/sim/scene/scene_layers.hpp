// Reads the layers of a lattice body, and the keys of laws that stiffen.
#pragma once

#include "turgor/models/lattice/build/cell_laws.hpp"
#include "turgor/sim/scene/scene_tissue.hpp"

namespace turgor {

/// "springs", "solid", "exponential" or "ogden".
const char* law_name(const lattice::TissueParams& params);

/// Reads `stiffening` (exponential) or `alpha` (ogden), each an error with another law.
void read_stiffening(SceneTable& table, const TissuePreset* preset, lattice::SolidEnergy energy,
                     double& value);
/// The value of that key, for the report.
LawValue stiffening_value(const SceneTable& table, const lattice::TissueParams& params);

/// Reads the array `layers` of a body, from the skin inward. Adds a row per layer to the report.
void read_layers(SceneTable& body, lattice::TissueParams& params, std::vector<TissueRow>& rows);

}  // namespace turgor
