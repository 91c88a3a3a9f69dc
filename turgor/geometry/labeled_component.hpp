// The voxels of a segmentation that a body is made of: those that have one of some labels, the largest
// connected part.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/geometry/volume.hpp"

namespace turgor {

struct LabeledPart {
  std::vector<std::uint8_t> inside;  // 1 for every sample of the part
  double volume = 0;                 // [m³]
  std::vector<std::string> notes;    // smaller parts left out; the part ends where the volume ends
};

/// Voxels are connected by their faces. Error: a label does not occur, with those that do.
Result<LabeledPart> largest_labeled_part(const LabelVolume& labels, std::span<const int> wanted);

}  // namespace turgor
