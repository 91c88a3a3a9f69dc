// Voxels of a body from a segmentation: the largest connected component of some labels.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/geometry/volume.hpp"

namespace turgor {

struct LabeledComponent {
  std::vector<std::uint8_t> inside;  // 1 for every sample of the component
  double volume = 0;                 // [m³]; with filled cavities
  std::vector<std::string> notes;    // ignored smaller components; contact with the border of the volume
};

/// A label of voxels that a component encloses.
struct EnclosedLabel {
  int label = 0;
  double volume = 0;  // [m³]
};

/// Labels of all voxels that are not inside and have no path over faces to the border of the volume,
/// ascending.
std::vector<EnclosedLabel> enclosed_labels(const LabelVolume& labels,
                                           const std::vector<std::uint8_t>& inside);

/// Adds the enclosed voxels to the component, except those of labels that are kept out. Returns the labels
/// that were added, ascending.
std::vector<EnclosedLabel> fill_cavities(const LabelVolume& labels, std::span<const int> kept_out,
                                         LabeledComponent& component);

/// Voxels are connected by their faces. Error: a label does not occur; the message lists those that do.
Result<LabeledComponent> largest_labeled_component(const LabelVolume& labels, std::span<const int> chosen);

}  // namespace turgor
