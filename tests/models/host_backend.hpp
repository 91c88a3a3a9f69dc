// Host backend in place of a GPU: device memory is host memory, and uploads and downloads are counted.
#pragma once

#include <gtest/gtest.h>

#include "turgor/models/lattice/device/device_body.hpp"

namespace turgor::lattice {

/// Bytes since the test reset them.
struct Transfers {
  static inline std::size_t uploaded = 0, downloaded = 0;
};

template <class T>
class CountedArray {
 public:
  CountedArray() = default;
  explicit CountedArray(std::size_t count) : values_(count) {}
  bool is_allocated() const { return true; }
  T* data() const { return const_cast<T*>(values_.data()); }
  std::size_t size() const { return values_.size(); }
  void upload(std::span<const T> from) {
    ASSERT_LE(from.size(), values_.size());
    std::copy(from.begin(), from.end(), values_.begin());
    Transfers::uploaded += from.size_bytes();
  }
  void download(std::span<T> to) const {
    ASSERT_LE(to.size(), values_.size());
    std::copy_n(values_.begin(), to.size(), to.begin());
    Transfers::downloaded += to.size_bytes();
  }

 private:
  std::vector<T> values_;
};

template <unsigned kSeed>
struct SeededRun : ShuffledRun {
  SeededRun() : ShuffledRun{kSeed} {}
};
template <int kThreads>
struct ThreadedRun {
  Exec exec = Exec(kThreads);

  template <class Kernel>
  void operator()(std::size_t count, const Kernel& kernel, std::size_t together = 64) const {
    CpuRun{exec}(count, kernel, together);
  }
};

template <class R>
struct HostBackend {
  template <class T>
  using Array = CountedArray<T>;
  using Run = R;
};

/// As put() for a GPU.
template <class R>
std::shared_ptr<BodyBackend> put_on_host(const Model& model) {
  DeviceAllocator<HostBackend<R>> allocator;
  return std::make_shared<DeviceBody<HostBackend<R>>>(model, allocator);
}

}  // namespace turgor::lattice
