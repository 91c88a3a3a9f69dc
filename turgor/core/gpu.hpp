// A GPU of NVIDIA, and memory on it. Built without CUDA, open_gpu says so and the rest is never reached: no
// program needs a driver or a toolkit to start.
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
  std::size_t free_bytes = 0;  // when it was opened
};
/// Error: what is missing, CUDA, a driver or a device.
Result<Gpu> open_gpu(int device = 0);

/// What is said where memory that `whose` needs is not there.
inline Error no_room(const std::string& whose, std::size_t bytes, const Gpu& gpu) {
  const auto megabytes = [](std::size_t n) { return std::to_string(n / 1000000) + " MB"; };
  return {whose + " needs " + megabytes(bytes) + " of a GPU's memory; " + gpu.name + " has " +
          megabytes(gpu.free_bytes) + " free"};
}

/// Plain memory of the current device; null when there is not so much.
void* allocate_on_gpu(std::size_t bytes);
void release_on_gpu(void* memory);
void upload_to_gpu(void* to, const void* from, std::size_t bytes);
void download_from_gpu(void* to, const void* from, std::size_t bytes);

/// Owns an array there; nothing goes over or back unless it is told to.
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
  /// To and from the first of them.
  void upload(std::span<const T> from) {
    TURGOR_ASSERT(from.size() <= size_, "there is room for as many");
    if (!from.empty()) upload_to_gpu(data_, from.data(), from.size_bytes());
  }
  void download(std::span<T> to) const {
    TURGOR_ASSERT(to.size() <= size_, "there are as many");
    if (!to.empty()) download_from_gpu(to.data(), data_, to.size_bytes());
  }

 private:
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace turgor
