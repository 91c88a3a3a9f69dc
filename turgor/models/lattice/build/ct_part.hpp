// Some slices of a CT, or all of them: the input of one process of a distributed body.
#pragma once

#include <cstdint>
#include <span>

#include "turgor/core/assert.hpp"
#include "turgor/geometry/volume.hpp"

namespace turgor::lattice {

struct CtSlab {
  const Grid& whole;
  int first = 0;                          // first slice of the samples
  std::span<const std::int16_t> samples;  // whole slices [HU]

  CtSlab(const CtVolume& ct) : whole(ct.grid), samples(ct.samples) {}
  CtSlab(const Grid& grid, int begin, std::span<const std::int16_t> values)
      : whole(grid), first(begin), samples(values) {}
  /// Row (j, k) of voxels of the whole CT.
  const std::int16_t* row(int j, int k) const {
    TURGOR_CHECK(
        k >= first && sample_index(whole, 0, j, k - first) + std::size_t(whole.size.x) <= samples.size(),
        "the row belongs to the slab");
    return samples.data() + sample_index(whole, 0, j, k - first);
  }
};

}  // namespace turgor::lattice
