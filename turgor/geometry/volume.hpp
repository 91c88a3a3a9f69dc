// A volume: one value per sample of a grid, i fastest. CT volumes hold Hounsfield units, label volumes hold
// the labels of a segmentation (0 = background).
#pragma once

#include <cstdint>
#include <vector>

#include "turgor/geometry/grid.hpp"

namespace turgor {

template <class T>
struct Volume {
  Grid grid;
  std::vector<T> samples;  // sample_count(grid) values

  T at(int i, int j, int k) const { return samples[sample_index(grid, i, j, k)]; }
  T& at(int i, int j, int k) { return samples[sample_index(grid, i, j, k)]; }
};

using CtVolume = Volume<std::int16_t>;      // [HU]
using LabelVolume = Volume<std::uint16_t>;  // 0 = background
using VectorVolume = Volume<Vec3>;          // directions, or displacements [m]
using ScalarVolume = Volume<float>;

constexpr std::int16_t kAirHu = -1000;

}  // namespace turgor
