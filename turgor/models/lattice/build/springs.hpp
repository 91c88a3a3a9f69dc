// Calibration of spring stiffness: a block of the lattice has the given Young's modulus.
#pragma once

#include <array>

#include "turgor/geometry/lattice.hpp"

namespace turgor::lattice {

/// Spring stiffness per unit of Young's modulus for the seven families [m]. A block stretched along any axis
/// has modulus E, and a sheared block G = 0.4 E, together with a volume energy of bulk modulus `volume` · E.
/// `spacing` [m].
std::array<Real, kFamilyCount> calibrate_springs(Vec3 spacing, double volume);

/// Homogenized stiffness matrix of an infinite lattice, per unit of Young's modulus, rows first. It maps
/// strains (xx, yy, zz, yz, xz, xy; shear strains as angles) to stresses.
///   C = Σ k L² n⊗n⊗n⊗n / V_cell + volume term      k: spring stiffness, L n: rest edge
/// [Cauchy 1828]
std::array<std::array<double, 6>, 6> homogenized_stiffness(Vec3 spacing,
                                                           const std::array<Real, kFamilyCount>& spring_scale,
                                                           double volume);

}  // namespace turgor::lattice
