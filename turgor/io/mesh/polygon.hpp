// A polygon in space as triangles. Internal to io/.
#pragma once

#include <span>
#include <vector>

#include "turgor/core/vec.hpp"

namespace turgor::io {

/// The most corners of a polygon that is not convex: cutting ears takes a time that grows with their cube.
constexpr std::size_t kMostConcaveCorners = 500;

/// Triangles between the corners, numbered from 0, the same way round. A convex polygon becomes a fan, any
/// other loses one ear after another. Nothing when it is not convex and has too many corners.
std::vector<Int3> triangulate(std::span<const Vec3d> corners);

}  // namespace turgor::io
