// Cuts in curved skin and along curves, against the linear finite elements of curved_wound.hpp.
#pragma once

#include "app/validation.hpp"

namespace turgor {

/// Adds gapes of straight cuts in cylinders and an ellipsoid, and of curved cuts in a slab, over the spacing
/// and the direction of the lattice.
void add_curved_wounds(const Exec& exec, std::vector<Figure>& figures);

}  // namespace turgor
