// Sides of quadratic tetrahedra that follow a round surface: the middles of outer edges are moved onto it.
#pragma once

#include <functional>

#include "turgor/core/exec.hpp"
#include "turgor/geometry/solid_mesh.hpp"

namespace turgor {

/// How thin an element may become where its map presses it most, as a part of what it has with flat sides.
constexpr double kLeastOfFlat = 0.3;

/// Moves the middles of a quadratic mesh's outer edges along the surface's normal to where `distance` [m],
/// about as steep as a distance and called by any thread, is zero; at most a quarter of the edge, and less
/// far where an element would become thinner than kLeastOfFlat.
void curve_sides(const Exec& exec, SolidMesh& quadratic, const std::function<double(Vec3d)>& distance);

/// The least determinant of an element's map at its nodes and inside, times a sixth [m³]: its volume if its
/// sides are flat, not positive if the map folds.
double least_map_volume(const SolidMesh& quadratic, std::size_t e);

}  // namespace turgor
