// Reads the layers of a lattice body, the keys of laws that stiffen, fibers and the permanent set.
#pragma once

#include "turgor/models/lattice/build/cell_laws.hpp"
#include "turgor/models/lattice/mechanics/solid_laws.hpp"
#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_label.hpp"
#include "turgor/sim/scene/scene_tissue.hpp"

namespace turgor {

/// "springs", "solid", "exponential" or "ogden".
const char* law_name(const lattice::TissueParams& params);
/// "solid", "exponential" or "ogden".
const char* law_name(lattice::SolidEnergy energy);

/// Reads `stiffening` (exponential) or `alpha` (ogden), each an error with another law.
void read_stiffening(SceneTable& table, const TissuePreset* preset, lattice::SolidEnergy energy,
                     double& value);
/// The value of that key, for the report.
LawValue stiffening_value(const SceneTable& table, lattice::SolidEnergy energy, double value);

/// Reads the table `fiber` of a tissue or a layer; an error with a law that has no fibers. `fiber` holds the
/// values of keys that are not given. `field`: file of the body's directions; null for a layer.
void read_fiber(SceneTable& table, lattice::SolidEnergy energy, lattice::FiberParams& fiber,
                std::filesystem::path* field = nullptr);
/// Row of the report for fibers of a component; none without fibers.
void add_fiber_row(SceneTable& table, const std::string& component, const lattice::FiberParams& fiber,
                   std::vector<TissueRow>& rows);

/// Reads the table `permanent_set` of a body.
void read_permanent_set(SceneTable& body, lattice::TissueParams& params, std::vector<TissueRow>& rows);

/// Keys of layers that are not of their laws.
struct LayerExtras {
  std::vector<NeedleLayerScene> tough;     // of layers that resist needles
  std::vector<std::optional<Rgb>> colors;  // of each layer
};

/// Reads the array `layers` of a body: layers by depth from the skin inward, and regions by label or CT
/// values. Adds their rows to the report. `has_labels`: the body has a segmentation, or a phantom's.
void read_layers(SceneTable& body, bool has_labels, SceneLabels& labels, lattice::TissueParams& params,
                 LayerExtras& extras, std::vector<TissueRow>& rows);

}  // namespace turgor
