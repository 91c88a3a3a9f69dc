// Reduces a CT to one body.
#pragma once

#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/geometry/volume.hpp"

namespace turgor {

/// Keeps the largest connected component of one label and what it encloses, such as a tumor of another label.
/// All other voxels become air, and the CT is cropped to the component plus `margin` voxels. Smaller
/// components are noted. Error: the label does not occur (the message lists those that do), or the component
/// is outside the CT.
Status crop_to_label(const Exec& exec, const LabelVolume& labels, int label, Int3 margin, CtVolume& ct,
                     std::vector<std::string>& notes);

}  // namespace turgor
