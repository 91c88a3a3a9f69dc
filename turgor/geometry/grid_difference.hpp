// Difference of two grids in words.
#pragma once

#include <string>

#include "turgor/geometry/grid.hpp"

namespace turgor {

/// First difference in size, spacing, axes and origin, with both values: "spacing 1 x 1 x 2 mm, not 1 x 1 x 3
/// mm". The order and direction of axes are ignored.
std::string grid_difference(const Grid& grid, const Grid& expected);

}  // namespace turgor
