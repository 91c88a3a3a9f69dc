// Whether the numbers of a volume can be Hounsfield units.
#pragma once

#include <string>

#include "turgor/geometry/volume.hpp"

namespace turgor {

/// A sentence with what was seen if neither air and soft tissue nor fat and muscle can be found in a volume:
/// another kind of image, or a CT whose scale got lost. Empty for a CT, or a piece of one. Looks at some four
/// million samples of a large volume.
std::string doubt_of_hounsfield_units(const CtVolume& ct);

}  // namespace turgor
