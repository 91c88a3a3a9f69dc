// Plausibility check of Hounsfield units.
#pragma once

#include <string>

#include "turgor/geometry/volume.hpp"

namespace turgor {

/// A warning with the observed values if a volume has neither air and soft tissue nor fat and muscle: another
/// kind of image, or a CT without its scale. Empty for a CT or a crop of one. About four million samples of a
/// large volume are inspected.
std::string doubt_of_hounsfield_units(const CtVolume& ct);

}  // namespace turgor
