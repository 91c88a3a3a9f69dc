// Slices of a CT, or all of them: what a process has read that makes a part of a body.
#pragma once

#include <cstdint>
#include <span>

#include "turgor/geometry/volume.hpp"

namespace turgor::lattice {

struct CtPart {
  const Grid& whole;
  int first = 0;                          // slice of the whole that the samples begin with
  std::span<const std::int16_t> samples;  // whole slices [HU]

  CtPart(const CtVolume& ct) : whole(ct.grid), samples(ct.samples) {}
  CtPart(const Grid& grid, int begin, std::span<const std::int16_t> values)
      : whole(grid), first(begin), samples(values) {}
  /// Of the row of voxels (j, k) of the whole.
  const std::int16_t* row(int j, int k) const {
    return samples.data() + sample_index(whole, 0, j, k - first);
  }
};

}  // namespace turgor::lattice
