// Reads the layers of a lattice body, the keys of laws that stiffen, fibers and the permanent set.
#pragma once

#include "turgor/models/lattice/build/cell_laws.hpp"
#include "turgor/models/lattice/mechanics/solid_laws.hpp"
#include "turgor/sim/scene/scene_tissue.hpp"

namespace turgor {

/// "springs", "solid", "exponential" or "ogden".
const char* law_name(const lattice::TissueParams& params);

/// Reads `stiffening` (exponential) or `alpha` (ogden), each an error with another law.
void read_stiffening(SceneTable& table, const TissuePreset* preset, lattice::SolidEnergy energy,
                     double& value);
/// The value of that key, for the report.
LawValue stiffening_value(const SceneTable& table, const lattice::TissueParams& params);

/// Reads the table `fiber` of a tissue or a layer; an error with a law that has no fibers. `fiber` holds the
/// values of keys that are not given.
void read_fiber(SceneTable& table, const lattice::TissueParams& params, lattice::FiberParams& fiber);
/// Row of the report for fibers of a component; none without fibers.
void add_fiber_row(SceneTable& table, const std::string& component, const lattice::FiberParams& fiber,
                   std::vector<TissueRow>& rows);

/// Reads the table `permanent_set` of a body.
void read_permanent_set(SceneTable& body, lattice::TissueParams& params, std::vector<TissueRow>& rows);

/// Reads the array `layers` of a body, from the skin inward. Adds a row per layer to the report.
void read_layers(SceneTable& body, lattice::TissueParams& params, std::vector<TissueRow>& rows);

}  // namespace turgor
