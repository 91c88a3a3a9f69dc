// Blade near a point of the drawn surface: a plane through the cut points around it, by moving least squares
// [Lancaster and Salkauskas 1981]. A fine edge stores the first blade that crossed it, so each blade has its
// own plane.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "turgor/models/lattice/cutting/fragments.hpp"

namespace turgor::lattice {

/// Crossing of a blade with a fine edge.
struct CutPoint {
  Vec3d position;             // [cells]
  Real along = 0;             // arc length on the blade's path [m]
  std::uint8_t incision = 0;  // index of the scene's incision
};
/// Cut points of a cell and of the fine edges within one fine node around it.
std::vector<CutPoint> cut_points_near(const Fragments& fragments, const Cuts& cuts, Int3 cell);

struct BladePlane {
  Vec3d point, normal;  // [cells]
};
/// Plane of an incision near a position [cells]. Cut points at another arc length than `along` belong to
/// another turn of the blade and are left out. Empty if fewer than three cut points are left, or if they lie
/// on a line.
std::optional<BladePlane> blade_plane_near(const FineLattice& fine, std::span<const CutPoint> points,
                                           std::uint8_t incision, Real along, Vec3d position);

}  // namespace turgor::lattice
