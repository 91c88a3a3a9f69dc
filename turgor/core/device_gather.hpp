// Download of two vectors per index, such as positions and velocities of some vertices. They are gathered on
// the device, so that only these bytes are transferred.
#pragma once

#include <span>
#include <vector>

#include "turgor/core/device_arrays.hpp"
#include "turgor/core/vec.hpp"

namespace turgor {

struct VectorPair {
  Vec3 first, second;
};

/// Gathers pairs, one thread per index. `At` is a functor: the pair of an index.
template <class At>
struct GatherPairs {
  At at;
  const int* indices;
  VectorPair* pairs;

  TURGOR_HD void operator()(std::size_t n) const { pairs[n] = at(indices[n]); }
};

template <class Backend>
class DeviceGather {
 public:
  /// Calls set(index, pair) for every index, in order. Throws OutOfDeviceMemory.
  template <class Run, class At, class Set>
  void operator()(const Run& run, std::span<const int> indices, const At& at, const Set& set) {
    if (indices.empty()) return;
    // gather on the device
    indices_.assign(indices), pairs_.resize(indices.size());
    run(indices.size(), GatherPairs<At>{at, indices_.data(), pairs_.data()});
    // download
    std::vector<VectorPair> pairs(indices.size());
    pairs_.array.download(pairs);
    for (std::size_t n = 0; n < pairs.size(); n++) set(std::size_t(indices[n]), pairs[n]);
  }

 private:
  DeviceList<Backend, int> indices_;
  DeviceList<Backend, VectorPair> pairs_;
};

}  // namespace turgor
