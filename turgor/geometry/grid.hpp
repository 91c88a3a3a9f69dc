// A regular grid of samples in the patient frame: size, spacing, origin and axes, as in a CT. Lengths in
// meters, points in the DICOM patient frame (LPS: x to the patient's left, y to the back, z to the head).
#pragma once

#include <cstddef>

#include "turgor/core/vec.hpp"

namespace turgor {

struct Grid {
  Int3 size;               // samples along i, j, k
  Vec3d spacing{1, 1, 1};  // [m]
  Vec3d origin;            // position of sample (0, 0, 0) [m]
  Mat3d axes;              // unit directions of i, j, k

  friend bool operator==(const Grid&, const Grid&) = default;
};

constexpr std::size_t sample_count(const Grid& grid) {
  return std::size_t(grid.size.x) * std::size_t(grid.size.y) * std::size_t(grid.size.z);
}
constexpr std::size_t sample_index(const Grid& grid, int i, int j, int k) {
  return (std::size_t(k) * std::size_t(grid.size.y) + std::size_t(j)) * std::size_t(grid.size.x) +
         std::size_t(i);
}
constexpr bool contains(const Grid& grid, Int3 p) {
  return p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x < grid.size.x && p.y < grid.size.y && p.z < grid.size.z;
}
/// Position of a (fractional) index [m].
constexpr Vec3d point_at(const Grid& grid, Vec3d index) {
  return grid.origin + grid.axes * hadamard(grid.spacing, index);
}
/// (Fractional) index of a position.
constexpr Vec3d index_at(const Grid& grid, Vec3d point) {
  const Vec3d local = inverse(grid.axes) * (point - grid.origin);
  return {local.x / grid.spacing.x, local.y / grid.spacing.y, local.z / grid.spacing.z};
}
/// Volume per sample [m³].
constexpr double sample_volume(const Grid& grid) { return grid.spacing.x * grid.spacing.y * grid.spacing.z; }

/// True if two grids have the same size and every corner agrees within a hundredth of the finest spacing
/// (files round their origins and directions).
constexpr bool same_grid(const Grid& a, const Grid& b) {
  if (!(a.size == b.size)) return false;
  const auto finest = [](Vec3d s) { return s.x < s.y ? (s.x < s.z ? s.x : s.z) : (s.y < s.z ? s.y : s.z); };
  const double tolerance = 0.01 * finest(a.spacing);
  for (int corner = 0; corner < 8; corner++) {
    const Vec3d index{corner & 1 ? a.size.x - 1.0 : 0.0, corner & 2 ? a.size.y - 1.0 : 0.0,
                      corner & 4 ? a.size.z - 1.0 : 0.0};
    const Vec3d difference = point_at(a, index) - point_at(b, index);
    if (!(dot(difference, difference) <= tolerance * tolerance)) return false;
  }
  return true;
}

}  // namespace turgor
