// A regular grid of samples placed in the patient: size, spacing, origin and axes, as in a CT. Lengths in metres, points in
// the DICOM patient frame (LPS: x to the patient's left, y to the back, z to the head).
#pragma once

#include <cstddef>

#include "turgor/core/vec.hpp"

namespace turgor {

struct Grid {
  Int3 size;               // samples along i, j, k
  Vec3d spacing{1, 1, 1};  // [m]
  Vec3d origin;            // place of sample (0, 0, 0) [m]
  Mat3d axes;              // unit directions of i, j, k

  friend bool operator==(const Grid&, const Grid&) = default;
};

constexpr std::size_t sample_count(const Grid& grid) {
  return std::size_t(grid.size.x) * std::size_t(grid.size.y) * std::size_t(grid.size.z);
}
constexpr std::size_t sample_index(const Grid& grid, int i, int j, int k) {
  return (std::size_t(k) * std::size_t(grid.size.y) + std::size_t(j)) * std::size_t(grid.size.x) + std::size_t(i);
}
constexpr bool contains(const Grid& grid, Int3 p) {
  return p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x < grid.size.x && p.y < grid.size.y && p.z < grid.size.z;
}
/// The place of a (fractional) index [m].
constexpr Vec3d point_at(const Grid& grid, Vec3d index) {
  return grid.origin + grid.axes * hadamard(grid.spacing, index);
}
/// The (fractional) index of a place.
constexpr Vec3d index_at(const Grid& grid, Vec3d point) {
  const Vec3d local = inverse(grid.axes) * (point - grid.origin);
  return {local.x / grid.spacing.x, local.y / grid.spacing.y, local.z / grid.spacing.z};
}
/// Volume that one sample stands for [m³].
constexpr double sample_volume(const Grid& grid) { return grid.spacing.x * grid.spacing.y * grid.spacing.z; }

}  // namespace turgor
