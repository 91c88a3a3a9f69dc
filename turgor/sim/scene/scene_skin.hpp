// Reads the keys of the laws of skin: stiffness, shear and stiffening; and states them for the report.
#pragma once

#include "turgor/models/lattice/model/params.hpp"
#include "turgor/sim/scene/scene_tissue.hpp"

namespace turgor {

/// "area", "fiber" or "exponential".
const char* skin_law_name(lattice::SkinLaw law);

/// Reads the stiffness keys. A key that belongs to another law is an error.
void read_skin_stiffness(SceneTable& table, lattice::SkinParams& skin);
/// The law bears the tension of the CT.
void check_skin_tension(SceneTable& table, const lattice::SkinParams& skin);
/// Rows of the report.
void add_skin_rows(const SceneTable& table, const lattice::SkinParams& skin, const TissuePreset* preset,
                   std::vector<TissueRow>& rows);

}  // namespace turgor
