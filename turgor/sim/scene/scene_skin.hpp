// Reads the keys of the laws of skin: stiffness, shear and stiffening; and states them for the report.
#pragma once

#include "turgor/models/lattice/model/params.hpp"
#include "turgor/sim/scene/scene_tissue.hpp"

namespace turgor {

/// "area", "fiber" or "exponential".
const char* skin_law_name(lattice::SkinLaw law);

/// Values of a preset: its tension, or the exponential law with its values.
void apply_skin_preset(const TissuePreset* preset, lattice::SkinParams& skin);
/// Refuses a preset of the exponential law beside another law, which has none of its values.
void check_skin_preset(SceneTable& body, const TissuePreset* preset, const lattice::SkinParams& skin);
/// Reads the stiffness keys. A key that belongs to another law is an error.
void read_skin_stiffness(SceneTable& table, lattice::SkinParams& skin);
/// The law bears the tension of the CT.
void check_skin_tension(SceneTable& table, const lattice::SkinParams& skin);
/// Rows of the report.
void add_skin_rows(const SceneTable& table, const lattice::SkinParams& skin, const TissuePreset* preset,
                   std::vector<TissueRow>& rows);

}  // namespace turgor
