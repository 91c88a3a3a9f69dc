// Shape functions of linear tetrahedra and of hexahedra, and the point of the reference element at a
// position.
#pragma once

#include <array>
#include <span>

#include "turgor/core/vec.hpp"

namespace turgor {

/// Barycentric coordinates of a position in a tetrahedron, with sum 1; negative outside.
std::array<double, 4> tet_coordinates(std::span<const Vec3d, 4> x, Vec3d p);

/// Trilinear shape functions of VTK's corners at a point of the cube [0, 1]³, and their gradients.
void trilinear(Vec3d s, std::span<double, 8> weight, std::array<Vec3d, 8>& gradient);

/// Newton iteration for the point of the cube that the hexahedron maps to p. It is kept near the cube,
/// because the map may fold outside.
Vec3d hex_coordinates(std::span<const Vec3d, 8> x, Vec3d p);

}  // namespace turgor
