// Interpolation of CT values between voxels.
#pragma once

#include <cmath>
#include <cstdint>

#include "turgor/geometry/volume.hpp"

namespace turgor {

TURGOR_HD inline std::int16_t round_to_hu(float value) {
  return std::int16_t(lrintf(value < -32768.0f ? -32768.0f : value > 32767.0f ? 32767.0f : value));
}

/// Trilinear interpolation in voxel indices; clamped beyond the outermost voxel centers.
struct CtSampler {
  const std::int16_t* samples;
  Vec3 last;   // index of the last center
  Int3 top;    // last cell between centers
  int next_x;  // strides in memory, 0 along an axis with one sample
  std::size_t row, layer, next_y, next_z;

  explicit CtSampler(const CtVolume& ct) : CtSampler(ct.samples.data(), ct.grid.size) {}
  /// Samples in host or device memory.
  CtSampler(const std::int16_t* ct, Int3 size)
      : samples(ct),
        last(size - Int3{1, 1, 1}),
        top(max(size - Int3{2, 2, 2}, Int3{0, 0, 0})),
        next_x(size.x > 1),
        row(std::size_t(size.x)),
        layer(row * std::size_t(size.y)),
        next_y(size.y > 1 ? row : 0),
        next_z(size.z > 1 ? layer : 0) {}

  TURGOR_HD float operator()(Vec3 at) const {
    at = min(max(at, Vec3{0, 0, 0}), last);
    const Int3 p = min(Int3(at), top);
    const Vec3 f = at - Vec3(p);
    const std::int16_t* v = samples + (std::size_t(p.z) * layer + std::size_t(p.y) * row + std::size_t(p.x));
    const auto along_x = [&](const std::int16_t* c) { return float(c[0]) + f.x * float(c[next_x] - c[0]); };
    const float y0 = along_x(v), y1 = along_x(v + next_y);
    const float y2 = along_x(v + next_z), y3 = along_x(v + next_z + next_y);
    const float z0 = y0 + f.y * (y1 - y0), z1 = y2 + f.y * (y3 - y2);
    return z0 + f.z * (z1 - z0);
  }
};

}  // namespace turgor
