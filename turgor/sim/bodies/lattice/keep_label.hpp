// A CT of one body alone.
#pragma once

#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/geometry/volume.hpp"

namespace turgor {

/// What a CT shows of the largest connected part of one label, in air: all other voxels become air, and the
/// CT is cut down to the part and `margin` voxels around it. Smaller parts are noted. Error: the label does
/// not occur, with those that do; or its part lies outside the CT.
Status keep_label(const Exec& exec, const LabelVolume& labels, int label, Int3 margin, CtVolume& ct,
                  std::vector<std::string>& notes);

}  // namespace turgor
