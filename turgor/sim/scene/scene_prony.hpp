// Reads the table `viscosity` of a body: one pair as `ratio` and `time`, or up to three as `pairs`.
#pragma once

#include "turgor/models/prony.hpp"
#include "turgor/sim/scene/scene_tissue.hpp"

namespace turgor {

/// Pairs of a preset (`g1`, `tau1`, …); `fallback` without them.
Prony prony_of(const TissuePreset* preset, const Prony& fallback);

/// Reads the table `viscosity`. `prony` holds the pairs of the preset or the default; given keys replace
/// them. Adds a row per pair to the report.
void read_viscosity(SceneTable table, const TissuePreset* preset, Prony& prony, std::vector<TissueRow>& rows,
                    const std::string& component = "viscosity");

}  // namespace turgor
