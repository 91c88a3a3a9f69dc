// How stiff the springs of a lattice must be for a block of it to answer like tissue of a given Young's
// modulus.
#pragma once

#include <array>

#include "turgor/geometry/lattice.hpp"

namespace turgor::lattice {

/// Spring stiffness per unit of Young's modulus for the seven families [m], for a lattice of this step [m],
/// such that a block stretched along any axis answers with E and a sheared one with G = 0.4 E, beside a
/// volume energy whose bulk stiffness is `volume` · E.
std::array<Real, kFamilyCount> calibrate_springs(Vec3 step, double volume);

/// The stiffness matrix of an infinite lattice with these springs, per unit of Young's modulus: strain (xx,
/// yy, zz, yz, xz, xy; shear strains as angles) to stress, rows first. [Cauchy 1828: Σ k L² n n n n / cell
/// volume]
std::array<std::array<double, 6>, 6> homogenized_stiffness(Vec3 step,
                                                           const std::array<Real, kFamilyCount>& spring_scale,
                                                           double volume);

}  // namespace turgor::lattice
