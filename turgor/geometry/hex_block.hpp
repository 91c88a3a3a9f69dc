// Plates and blocks of hexahedra, optionally split into tetrahedra: bodies with known solutions.
#pragma once

#include <span>

#include "turgor/geometry/solid_mesh.hpp"

namespace turgor {

/// Hexahedra between planes at these coordinates, ascending [m]. Vertices are numbered along x, then y, then
/// z.
SolidMesh hex_block(std::span<const double> x, std::span<const double> y, std::span<const double> z);
/// `count` equal hexahedra along each axis from the origin to `size` [m].
SolidMesh hex_block(Vec3d size, Int3 count);
/// Splits every hexahedron of a block into six tetrahedra around its main diagonal.
SolidMesh tetrahedralize(const SolidMesh& hexahedra);

}  // namespace turgor
