// Strain of a patch's surface, by which a report says where the linear answer ends.
#pragma once

#include <span>

#include "turgor/models/sfem/patch.hpp"

namespace turgor::sfem {

/// Strain of the surface from which on the force of a linear body is off by more than 5 %. Measured for balls
/// on layers of a neo-Hookean material (tests/contact/law_press.cpp); tissue that stiffens leaves it earlier.
constexpr double kLinearStrain = 0.25;

/// Largest principal Green strain |½ (λ² − 1)| of the triangles of a patch in their planes, with its points
/// at these positions [m].
double largest_surface_strain(const Patch& patch, std::span<const Vec3d> x);

}  // namespace turgor::sfem
