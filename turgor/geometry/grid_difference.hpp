// Difference of two grids in words.
#pragma once

#include <string>

#include "turgor/geometry/grid.hpp"

namespace turgor {

/// First difference in size, spacing, axes and origin, with both values: "spacing 1 x 1 x 2 mm, not 1 x 1 x 3
/// mm". The order and direction of axes are ignored.
std::string grid_difference(const Grid& grid, const Grid& expected);

/// The same for a grid that should cover a sub-box of `whole`, sample on sample: spacing, axes, an origin
/// between samples, or samples outside.
std::string box_difference(const Grid& box, const Grid& whole);

}  // namespace turgor
