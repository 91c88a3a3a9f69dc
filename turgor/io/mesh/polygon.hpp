// Triangulation of polygons in space by ear clipping. Internal to io/.
#pragma once

#include <span>
#include <vector>

#include "turgor/core/vec.hpp"

namespace turgor::io {

/// Most corners of a polygon that is not convex, because ear clipping takes cubic time.
constexpr std::size_t kMostConcaveCorners = 500;

/// Triangles between the corners, numbered from 0, with the same orientation. A convex polygon becomes a fan;
/// other polygons are clipped ear by ear. Empty if the polygon is not convex and has too many corners.
std::vector<Int3> triangulate(std::span<const Vec3d> corners);

}  // namespace turgor::io
