// Trilinear interpolation of CT values by fractional index, for sections and the ray caster.
#pragma once

#include <algorithm>

#include "turgor/geometry/volume.hpp"

namespace turgor {

/// True within half a sample of the outermost samples.
inline bool inside_samples(const Grid& grid, Vec3d index) {
  for (int axis = 0; axis < 3; axis++)
    if (index[axis] < -0.5 || index[axis] > grid.size[axis] - 0.5) return false;
  return true;
}

/// Samples of a CT in host or device memory.
struct Samples {
  const std::int16_t* values;
  Int3 size;

  TURGOR_HD const std::int16_t* at(int i, int j, int k) const {
    return values + (std::size_t(k) * std::size_t(size.y) + std::size_t(j)) * std::size_t(size.x) +
           std::size_t(i);
  }
};
inline Samples samples_of(const CtVolume& ct) { return {ct.samples.data(), ct.grid.size}; }

/// Value at an index in [0, size - 1] along every axis, of a volume at least two samples thick.
TURGOR_HD inline float sample_linear(const Samples& ct, Vec3 index) {
  const Int3 n = ct.size;
  const int i = std::min(int(index.x), n.x - 2), j = std::min(int(index.y), n.y - 2),
            k = std::min(int(index.z), n.z - 2);
  const float u = index.x - float(i), v = index.y - float(j), w = index.z - float(k);
  const std::size_t row = std::size_t(n.x), layer = row * std::size_t(n.y);
  const std::int16_t* s = ct.at(i, j, k);
  const auto edge = [u](const std::int16_t* p) { return float(p[0]) + u * float(p[1] - p[0]); };
  const float low = edge(s) + v * (edge(s + row) - edge(s));
  const float high = edge(s + layer) + v * (edge(s + layer + row) - edge(s + layer));
  return low + w * (high - low);
}

inline float sample_linear(const CtVolume& ct, Vec3 index) { return sample_linear(samples_of(ct), index); }

/// Value at any index, clamped to the volume; works for volumes one sample thick.
inline float sample_clamped(const CtVolume& ct, Vec3 index) {
  const Int3 n = ct.grid.size;
  Int3 low, high;
  float weight[3];
  for (int axis = 0; axis < 3; axis++) {
    const float x = std::clamp(index[axis], 0.0f, float(n[axis] - 1));
    low[axis] = int(x);
    high[axis] = std::min(low[axis] + 1, n[axis] - 1);
    weight[axis] = x - float(low[axis]);
  }
  float sum = 0;
  for (int corner = 0; corner < 8; corner++) {
    const bool bx = corner & 1, by = corner & 2, bz = corner & 4;
    const float share = (bx ? weight[0] : 1 - weight[0]) * (by ? weight[1] : 1 - weight[1]) *
                        (bz ? weight[2] : 1 - weight[2]);
    sum += share * float(ct.at(bx ? high.x : low.x, by ? high.y : low.y, bz ? high.z : low.z));
  }
  return sum;
}

}  // namespace turgor
