// Points sorted into cells on one side of a bus or the other, by the same hashing as on the CPU and in its
// order (spatial_hash.hpp).
#pragma once

#include <bit>

#include "turgor/core/device_lists.hpp"
#include "turgor/models/cloth/contact/spatial_hash.hpp"
#include "turgor/models/cloth/device/sheet_view.hpp"

namespace turgor::cloth {

template <class Side>
VectorsView view(const DeviceVectors<Side>& a) {
  return {a.x.data(), a.y.data(), a.z.data()};
}

/// NearPoints there.
struct NearView {
  Real cell;
  std::uint32_t mask;
  const int *begin, *index;
  int count;
  VectorsView at;  // places by bucket [m]

  TURGOR_HD bool is_all(Vec3 low, Vec3 high) const { return CellBox(1 / cell, low, high).is_all(mask); }
  /// Calls take(point, place) for all points of a box, and some beside it.
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
struct PlaceSorted {
  NearView near;
  ConstVectorsView x;

  TURGOR_HD void operator()(std::size_t n) const { near.at.set(n, x[std::size_t(near.index[n])]); }
};

template <class Side>
class DeviceSpatialHash {
 public:
  DeviceSpatialHash(DeviceAllocator<Side>& rooms, std::size_t count) : sorted_(rooms, count) {}

  /// sort_points, of as many as there is room for.
  template <class Run>
  NearView sort(const Run& run, ConstVectorsView points, Real cell) {
    const std::size_t count = sorted_.x.size();
    const std::size_t buckets = std::bit_ceil(std::max<std::size_t>(count, 64));
    const auto mask = std::uint32_t(buckets - 1);
    of_bucket_.make(run, buckets, count, BucketOf{points, 1 / cell, mask});
    const NearView near{cell,       mask,         of_bucket_.begin.data(), of_bucket_.item.data(),
                        int(count), view(sorted_)};
    run(count, PlaceSorted{near, points});
    return near;
  }

 private:
  DeviceVectors<Side> sorted_;
  DeviceLists<Side> of_bucket_;
};

}  // namespace turgor::cloth
