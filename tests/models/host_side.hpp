// In place of a GPU: the other side of the bus is the host too, and what goes over or back is counted.
#pragma once

#include "turgor/models/lattice/device/device_body.hpp"

namespace turgor::lattice {

/// Bytes since the test set them to 0.
struct Bus {
  static inline std::size_t over = 0, back = 0;
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
    Bus::over += from.size_bytes();
  }
  void download(std::span<T> to) const {
    ASSERT_LE(to.size(), values_.size());
    std::copy_n(values_.begin(), to.size(), to.begin());
    Bus::back += to.size_bytes();
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
struct HostSide {
  template <class T>
  using Array = CountedArray<T>;
  using Run = R;
};

/// As put() does it with a GPU.
template <class R>
std::shared_ptr<BodyBackend> put_on_host(const Model& model) {
  DeviceAllocator<HostSide<R>> rooms;
  return std::make_shared<DeviceBody<HostSide<R>>>(model, rooms);
}

}  // namespace turgor::lattice
