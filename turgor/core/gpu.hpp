// An NVIDIA GPU and memory on it. In builds without CUDA, open_gpu returns an error and nothing else is
// called, so no program needs a driver or a toolkit to start.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>

#include "turgor/core/result.hpp"

namespace turgor {

struct Gpu {
  int device = 0;
  std::string name;
  std::size_t free_bytes = 0;  // when the device was opened
};
/// Error: CUDA, a driver or a device is missing.
Result<Gpu> open_gpu(int device = 0);

/// Error for data (`owner`) that does not fit into device memory.
inline Error out_of_memory(const std::string& owner, std::size_t bytes, const Gpu& gpu) {
  const auto megabytes = [](std::size_t n) { return std::to_string(n / 1000000) + " MB"; };
  return {owner + " needs " + megabytes(bytes) + " of GPU memory; " + gpu.name + " has " +
          megabytes(gpu.free_bytes) + " free"};
}

/// Device memory of the current GPU; null when there is not enough.
void* allocate_on_gpu(std::size_t bytes);
void release_on_gpu(void* memory);
void upload_to_gpu(void* to, const void* from, std::size_t bytes);
void download_from_gpu(void* to, const void* from, std::size_t bytes);

/// Owns an array in device memory. Transfers are explicit.
template <class T>
class GpuArray {
 public:
  GpuArray() = default;
  explicit GpuArray(std::size_t count)
      : data_(static_cast<T*>(allocate_on_gpu(count * sizeof(T)))), size_(count) {}
  GpuArray(GpuArray&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}
  GpuArray& operator=(GpuArray other) noexcept {
    std::swap(data_, other.data_), std::swap(size_, other.size_);
    return *this;
  }
  ~GpuArray() {
    if (data_) release_on_gpu(data_);
  }

  bool is_allocated() const { return data_ != nullptr || size_ == 0; }
  T* data() const { return data_; }
  std::size_t size() const { return size_; }
  /// Transfer of the first from.size() or to.size() values.
  void upload(std::span<const T> from) {
    TURGOR_ASSERT(from.size() <= size_, "the array is large enough for the upload");
    if (!from.empty()) upload_to_gpu(data_, from.data(), from.size_bytes());
  }
  void download(std::span<T> to) const {
    TURGOR_ASSERT(to.size() <= size_, "the array has as many values as the download");
    if (!to.empty()) download_from_gpu(to.data(), data_, to.size_bytes());
  }

 private:
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace turgor
