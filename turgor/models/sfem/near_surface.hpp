// Which elements lie near the surface: those that a tool can reach.
#pragma once

#include <cstdint>
#include <vector>

#include "turgor/geometry/solid_mesh.hpp"

namespace turgor::sfem {

/// The point of a triangle that is nearest to p.
Vec3d nearest_on_triangle(Vec3d p, Vec3d a, Vec3d b, Vec3d c);

/// 1 for every element that has a face in the surface, or its centroid at most `depth` [m] from it.
std::vector<std::uint8_t> near_surface(const SolidMesh& mesh, const SolidSurface& surface, double depth);

}  // namespace turgor::sfem
