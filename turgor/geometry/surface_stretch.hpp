// Largest principal stretch of a deformed surface: how much longer its most stretched direction became.
//   F maps rest edges of a triangle to present ones; λ₁² is the larger root of det(G − λ² G₀) = 0
// with the metrics G₀ = E₀ᵀE₀ and G = EᵀE of two edges at rest and now.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "turgor/core/vec.hpp"

namespace turgor {

/// Largest principal stretch of a triangle [1]; 0 if it has no area at rest.
double principal_stretch(const std::array<Vec3d, 3>& rest, const std::array<Vec3d, 3>& now);

/// Mean of the triangles around every vertex, weighted with their areas at rest [1]. Vertices without
/// triangles have 1.
std::vector<float> principal_stretches(std::span<const Vec3> rest, std::span<const Vec3> now,
                                       std::span<const Int3> triangles);

/// Vertex around which a surface is stretched most, and the mean there.
struct DiscStretch {
  std::size_t vertex = 0;
  double mean = 1;  // [1]
};
/// Largest mean over the triangles whose centroids are within a radius [m] of a vertex at rest, weighted with
/// their areas at rest. A single thin triangle does not decide it, and meshes of other sizes have nearly the
/// same value.
DiscStretch largest_stretch_of_discs(std::span<const Vec3> rest, std::span<const Vec3> now,
                                     std::span<const Int3> triangles, double radius);

}  // namespace turgor
