// Arrays of one side of a bus or the other, and what they need of its memory. A side has Array<T>: made with
// a count, is_there, size, data, upload and download of the first of its values (gpu.hpp), and a Run
// (run.hpp).
#pragma once

#include <cstddef>
#include <span>

#include "turgor/core/assert.hpp"
#include "turgor/core/config.hpp"

namespace turgor {

/// Makes arrays of a side, as long as there is room, and counts what all of them need.
template <class Side>
struct DeviceAllocator {
  std::size_t bytes = 0;
  bool all_allocated = true;

  template <class T>
  typename Side::template Array<T> room(std::size_t count) {
    bytes += count * sizeof(T);
    if (!all_allocated) return {};
    typename Side::template Array<T> array(count);
    all_allocated = array.is_allocated();
    return array;
  }
  /// With what a vector holds.
  template <class Values>
  auto copy(const Values& values) {
    using T = typename Values::value_type;
    auto array = room<T>(values.size());
    if (all_allocated) array.upload(std::span<const T>(values.data(), values.size()));
    return array;
  }
};

/// Three numbers each, such as displacements, in an array of their own.
template <class Side>
struct DeviceVectors {
  typename Side::template Array<Real> x, y, z;

  DeviceVectors(DeviceAllocator<Side>& rooms, std::size_t count)
      : x(rooms.template room<Real>(count)),
        y(rooms.template room<Real>(count)),
        z(rooms.template room<Real>(count)) {}
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
template <class Side, class T>
struct DeviceList {
  typename Side::template Array<T> room;
  std::size_t count = 0;

  /// Is there room for so many?
  bool fits(std::size_t wanted, std::size_t spare = 0) {
    if (wanted > room.size()) room = {}, room = typename Side::template Array<T>(wanted + spare);
    count = room.is_allocated() ? wanted : 0;
    return room.is_allocated();
  }
  void fit(std::size_t wanted) {
    [[maybe_unused]] const bool there = fits(wanted, wanted / 2);
    TURGOR_ASSERT(there, "a GPU has memory left for what a step or a cut adds to a body");
  }
  /// With these, if there is room for them.
  bool holds(std::span<const T> values) {
    if (!fits(values.size(), values.size() / 2)) return false;
    room.upload(values);
    return true;
  }
  void put(std::span<const T> values) {
    fit(values.size());
    room.upload(values);
  }
  T* data() const { return room.data(); }
  std::span<const T> values() const { return {room.data(), count}; }
};

}  // namespace turgor
