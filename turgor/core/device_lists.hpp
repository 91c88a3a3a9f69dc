// Counting sort of indices by key on the host or a device. Indices ascend within a key, so the result does
// not depend on the order in which threads run.
#pragma once

#include <vector>

#include "turgor/core/atomic_max.hpp"
#include "turgor/core/device_arrays.hpp"

namespace turgor {

struct ClearInts {
  int* list;

  TURGOR_HD void operator()(std::size_t n) const { list[n] = 0; }
};
struct CopyInts {
  const int* from;
  int* to;

  TURGOR_HD void operator()(std::size_t n) const { to[n] = from[n]; }
};

/// Values that one thread sums: a cache line.
constexpr std::size_t kScanBlock = 32;
struct SumBlock {
  const int* list;
  std::size_t count;
  int* sums;

  TURGOR_HD void operator()(std::size_t block) const {
    int sum = 0;
    for (std::size_t n = block * kScanBlock; n < count && n < (block + 1) * kScanBlock; n++) sum += list[n];
    sums[block] = sum;
  }
};
struct ScanBlock {
  int* list;
  std::size_t count;
  const int* sums;  // sum before each block; null = there is only one block

  TURGOR_HD void operator()(std::size_t block) const {
    int sum = sums != nullptr ? sums[block] : 0;
    for (std::size_t n = block * kScanBlock; n < count && n < (block + 1) * kScanBlock; n++) {
      const int value = list[n];
      list[n] = sum;
      sum += value;
    }
  }
};

/// Exclusive prefix sum in place.
template <class Backend>
class DeviceScan {
 public:
  template <class Run>
  void operator()(const Run& run, int* list, std::size_t count, std::size_t level = 0) {
    const std::size_t blocks = (count + kScanBlock - 1) / kScanBlock;
    if (blocks <= 1) return run(blocks, ScanBlock{list, count, nullptr});
    if (sums_.size() == level) sums_.emplace_back();
    sums_[level].resize(blocks);
    int* sums = sums_[level].data();
    run(blocks, SumBlock{list, count, sums});
    (*this)(run, sums, blocks, level + 1);
    run(blocks, ScanBlock{list, count, sums});
  }

 private:
  std::vector<DeviceList<Backend, int>> sums_;  // by level
};

/// Key is a functor: the key of n, or -1 to skip n.
template <class Key>
struct CountKey {
  Key key;
  int* count;

  TURGOR_HD void operator()(std::size_t n) const {
    if (const int k = key(n); k >= 0) atomic_next(count[k]);
  }
};
template <class Key>
struct FillKey {
  Key key;
  int *next, *item;

  TURGOR_HD void operator()(std::size_t n) const {
    if (const int k = key(n); k >= 0) item[atomic_next(next[k])] = int(n);
  }
};
/// FillKey writes the items of a key in any order; this sorts them.
struct SortKey {
  const int* begin;
  int* item;

  TURGOR_HD void operator()(std::size_t k) const {
    for (int n = begin[k] + 1; n < begin[k + 1]; n++) {
      const int moved = item[n];
      int at = n;
      for (; at > begin[k] && item[at - 1] > moved; at--) item[at] = item[at - 1];
      item[at] = moved;
    }
  }
};

/// Items with key k are item[begin[k]] … item[begin[k + 1] - 1].
template <class Backend>
struct DeviceLists {
  DeviceList<Backend, int> begin, next, item;
  DeviceScan<Backend> scan;

  /// Sorts the indices 0 … count - 1.
  template <class Run, class Key>
  void make(const Run& run, std::size_t keys, std::size_t count, const Key& key) {
    begin.resize(keys + 1), next.resize(keys + 1), item.resize(count);
    run(keys + 1, ClearInts{begin.data()});
    run(count, CountKey<Key>{key, begin.data()});
    scan(run, begin.data(), keys + 1);
    run(keys + 1, CopyInts{begin.data(), next.data()});
    run(count, FillKey<Key>{key, next.data(), item.data()});
    run(keys, SortKey{begin.data(), item.data()});
  }
};

}  // namespace turgor
