// Spatial hash on the device, with the hash function and the order of the host (spatial_hash.hpp).
#pragma once

#include <bit>

#include "turgor/core/device_lists.hpp"
#include "turgor/models/cloth/contact/spatial_hash.hpp"
#include "turgor/models/cloth/model/sheet_view.hpp"

namespace turgor::cloth {

template <class Backend>
VectorsView view(const DeviceVectors<Backend>& a) {
  return {a.x.data(), a.y.data(), a.z.data()};
}

/// SpatialHash on the device.
struct NearView {
  Real cell;
  std::uint32_t mask;
  const int *begin, *index;
  int count;
  VectorsView at;  // positions by bucket [m]

  TURGOR_HD bool is_all(Vec3 low, Vec3 high) const { return CellBox(1 / cell, low, high).is_all(mask); }
  /// Calls take(point, position) for all points of a box, and some outside it.
  template <class Take>
  TURGOR_HD void visit(Vec3 low, Vec3 high, const Take& take) const {
    visit_runs(cell, mask, begin, count, low, high, [&](int from, int to, const auto& is_own) {
      for (int n = from; n < to; n++)
        if (const Vec3 p = at[std::size_t(n)]; is_own(p)) take(index[n], p);
    });
  }
};
struct BucketOf {
  ConstVectorsView x;
  Real inverse_cell;
  std::uint32_t mask;

  TURGOR_HD int operator()(std::size_t i) const {
    const std::uint32_t row = row_bucket(cell_of(x.y[i], inverse_cell), cell_of(x.z[i], inverse_cell));
    return int((row + std::uint32_t(cell_of(x.x[i], inverse_cell))) & mask);
  }
};
struct GatherSorted {
  NearView near;
  ConstVectorsView x;

  TURGOR_HD void operator()(std::size_t n) const { near.at.set(n, x[std::size_t(near.index[n])]); }
};

template <class Backend>
class DeviceSpatialHash {
 public:
  DeviceSpatialHash(DeviceAllocator<Backend>& allocator, std::size_t count) : sorted_(allocator, count) {}

  /// sort_points for the allocated number of points.
  template <class Run>
  NearView sort(const Run& run, ConstVectorsView points, Real cell) {
    const std::size_t count = sorted_.x.size();
    const std::size_t buckets = std::bit_ceil(std::max<std::size_t>(count, 64));
    const auto mask = std::uint32_t(buckets - 1);
    of_bucket_.make(run, buckets, count, BucketOf{points, 1 / cell, mask});
    const NearView near{cell,       mask,         of_bucket_.begin.data(), of_bucket_.item.data(),
                        int(count), view(sorted_)};
    run(count, GatherSorted{near, points});
    return near;
  }

 private:
  DeviceVectors<Backend> sorted_;
  DeviceLists<Backend> of_bucket_;
};

}  // namespace turgor::cloth
