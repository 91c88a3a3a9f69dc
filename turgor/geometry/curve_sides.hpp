// Curved sides of quadratic tetrahedra: midside nodes of outer edges are moved onto a smooth surface.
#pragma once

#include <functional>

#include "turgor/core/exec.hpp"
#include "turgor/geometry/solid_mesh.hpp"

namespace turgor {

/// Smallest Jacobian determinant that curving may leave, as a fraction of that of the straight element.
constexpr double kLeastOfFlat = 0.3;

/// Moves midside nodes of outer edges along the surface normal to the zero of `distance` [m], whose slope is
/// about that of a distance and which any thread may call. The move is at most a quarter of the edge. It is
/// reduced if an element's determinant would fall below kLeastOfFlat.
void curve_sides(const Exec& exec, SolidMesh& quadratic, const std::function<double(Vec3d)>& distance);

/// Smallest determinant of an element's map at its nodes and interior points, times a sixth [m³]. It equals
/// the volume for straight edges, and is not positive if the map folds.
double least_map_volume(const SolidMesh& quadratic, std::size_t e);

}  // namespace turgor
