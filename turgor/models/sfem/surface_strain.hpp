// Strain of a patch's surface, by which a report says where the linear answer ends.
#pragma once

#include <span>

#include "turgor/models/sfem/patch.hpp"

namespace turgor::sfem {

/// Strain of the surface from which on the force of a linear body is off by about 5 %. For a ball on a layer
/// of a neo-Hookean material as thick as its radius, the force is 1.5 % too small at a strain of 7 % and 11 %
/// too small at 18 %. Tissue that stiffens leaves the linear answer earlier.
constexpr double kLinearStrain = 0.1;

/// Largest principal Green strain |½ (λ² − 1)| of triangles in their planes, between positions of their
/// vertices at rest and now [m].
double largest_surface_strain(std::span<const Int3> triangles, std::span<const Vec3d> rest,
                              std::span<const Vec3d> x);
/// The same of the triangles of a patch, with its points at these positions [m].
double largest_surface_strain(const Patch& patch, std::span<const Vec3d> x);

}  // namespace turgor::sfem
