// Values of a CT between its voxels.
#pragma once

#include <cstdint>

#include "turgor/geometry/volume.hpp"

namespace turgor::lattice {

/// Trilinear, in voxel indices; beyond the outermost centres their values go on.
struct Sampler {
  const std::int16_t* samples;
  Vec3 last;   // index of the last centre
  Int3 top;    // the last cell between centres
  int next_x;  // distances in memory, 0 along an axis with one sample
  std::size_t row, layer, next_y, next_z;

  explicit Sampler(const CtVolume& ct)
      : samples(ct.samples.data()),
        last(ct.grid.size - Int3{1, 1, 1}),
        top(max(ct.grid.size - Int3{2, 2, 2}, Int3{0, 0, 0})),
        next_x(ct.grid.size.x > 1),
        row(std::size_t(ct.grid.size.x)),
        layer(row * std::size_t(ct.grid.size.y)),
        next_y(ct.grid.size.y > 1 ? row : 0),
        next_z(ct.grid.size.z > 1 ? layer : 0) {}

  float operator()(Vec3 at) const {
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

}  // namespace turgor::lattice
