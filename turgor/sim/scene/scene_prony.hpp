// Reads the table `viscosity` of a body: one pair as `ratio` and `time`, up to three as `pairs`, or those of
// a `preset`.
#pragma once

#include "turgor/models/prony.hpp"
#include "turgor/sim/scene/scene_tissue.hpp"

namespace turgor {

/// Pairs of a preset (`g1`, `tau1`, …); `fallback` without them.
Prony prony_of(const TissuePreset* preset, const Prony& fallback);

/// Refuses an empty table `viscosity` of a body or layer whose preset has no pairs: nothing would relax.
void check_pairs_of_preset(SceneTable& owner, const TissuePreset* preset);

/// Reads the table `viscosity`. `prony` holds the pairs of the preset or the default; given keys replace
/// them. Adds a row per pair to the report.
void read_viscosity(SceneTable table, const TissuePreset* preset, Prony& prony, std::vector<TissueRow>& rows,
                    const std::string& component = "viscosity");

}  // namespace turgor
