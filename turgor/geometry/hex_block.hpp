// Plates and blocks of hexahedra, and the same cut into tetrahedra: bodies whose answers are known.
#pragma once

#include <span>

#include "turgor/geometry/solid_mesh.hpp"

namespace turgor {

/// Hexahedra between planes at these coordinates, ascending [m]. Vertices are numbered along x, then y, then
/// z.
SolidMesh hex_block(std::span<const double> x, std::span<const double> y, std::span<const double> z);
/// `count` equal hexahedra along each axis from the origin to `size` [m].
SolidMesh hex_block(Vec3d size, Int3 count);
/// Every hexahedron of a block cut into six tetrahedra around its main diagonal.
SolidMesh tetrahedralize(const SolidMesh& hexahedra);

}  // namespace turgor
