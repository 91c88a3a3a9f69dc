// Arrays on a device or on the host, and an allocator that counts their bytes. A Backend has Array<T>
// (constructed with a count; is_allocated, size, data, upload and download of the first values; gpu.hpp) and
// a Run (run.hpp).
#pragma once

#include <cstddef>
#include <new>
#include <span>

#include "turgor/core/config.hpp"

namespace turgor {

/// Thrown when a list of a step, a cut or a download does not fit into device memory. States catch it and
/// continue on the host (mirrored_state.hpp).
struct OutOfDeviceMemory : std::bad_alloc {
  const char* what() const noexcept override { return "device memory ran out"; }
};

/// Allocates arrays of a backend until memory runs out, and counts the bytes that all of them need.
template <class Backend>
struct DeviceAllocator {
  std::size_t bytes = 0;
  bool all_allocated = true;

  template <class T>
  typename Backend::template Array<T> allocate(std::size_t count) {
    bytes += count * sizeof(T);
    if (!all_allocated) return {};
    typename Backend::template Array<T> array(count);
    all_allocated = array.is_allocated();
    return array;
  }
  /// Array with the contents of a vector.
  template <class Values>
  auto copy(const Values& values) {
    using T = typename Values::value_type;
    auto array = allocate<T>(values.size());
    if (all_allocated) array.upload(std::span<const T>(values.data(), values.size()));
    return array;
  }
};

/// Three-component vectors (such as displacements), one array per component.
template <class Backend>
struct DeviceVectors {
  typename Backend::template Array<Real> x, y, z;

  DeviceVectors(DeviceAllocator<Backend>& allocator, std::size_t count)
      : x(allocator.template allocate<Real>(count)),
        y(allocator.template allocate<Real>(count)),
        z(allocator.template allocate<Real>(count)) {}
  template <class Vectors>
  void upload(const Vectors& from) {
    x.upload(from.x), y.upload(from.y), z.upload(from.z);
  }
  template <class Vectors>
  void download(Vectors& to) const {
    x.download(to.x), y.download(to.y), z.download(to.z);
  }
};

/// A list whose length changes between steps.
template <class Backend, class T>
struct DeviceList {
  typename Backend::template Array<T> array;
  std::size_t count = 0;

  /// Sets the length; false if memory is short. A reallocation has `spare` extra entries.
  bool try_resize(std::size_t new_count, std::size_t spare = 0) {
    if (new_count > array.size()) array = {}, array = typename Backend::template Array<T>(new_count + spare);
    const bool is_allocated = array.is_allocated();
    if (!is_allocated) array = {};
    count = is_allocated ? new_count : 0;
    return is_allocated;
  }
  /// The same, with half as many extra entries if memory permits.
  bool try_resize_generously(std::size_t new_count) {
    return try_resize(new_count, new_count / 2) || try_resize(new_count);
  }
  /// Sets the length. Throws OutOfDeviceMemory; the list is empty then.
  void resize(std::size_t new_count) {
    if (!try_resize_generously(new_count)) throw OutOfDeviceMemory();
  }
  /// Sets length and contents; false if memory is short.
  bool try_assign(std::span<const T> values) {
    if (!try_resize_generously(values.size())) return false;
    array.upload(values);
    return true;
  }
  /// Sets length and contents. Throws as resize.
  void assign(std::span<const T> values) {
    resize(values.size());
    array.upload(values);
  }
  T* data() const { return array.data(); }
  std::span<const T> values() const { return {array.data(), count}; }
};

}  // namespace turgor
