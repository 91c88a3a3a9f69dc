// How two grids that should be the same differ, in words.
#pragma once

#include <string>

#include "turgor/geometry/grid.hpp"

namespace turgor {

/// The first thing that differs, of size, spacing, axes and origin, with both values: "spacing 1 x 1 x 2 mm,
/// not 1 x 1 x 3 mm". Axes in another order or direction are no difference.
std::string grid_difference(const Grid& grid, const Grid& expected);

}  // namespace turgor
