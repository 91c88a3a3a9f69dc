// Structs of callers compiled with an older or a newer header: the common members are copied, the rest keeps
// its default or stays unchanged.
#pragma once

#include <algorithm>
#include <cstring>

#include "c/guard.hpp"

namespace turgor::c {

/// Bytes that no struct reaches; a larger size is one that was never set.
constexpr std::size_t kMostBytes = std::size_t(1) << 16;

/// Copy of the caller's struct, completed by `defaults`. `size` is its first member.
template <class T>
T taken(const T* given, T defaults) {
  expect(given != nullptr, "expected a struct, found null");
  std::size_t size = 0;
  std::memcpy(&size, given, sizeof size);
  expect(size >= sizeof size && size < kMostBytes, "expected a struct that begins with its size");
  std::memcpy(static_cast<void*>(&defaults), given, std::min(size, sizeof(T)));
  defaults.size = size;
  return defaults;
}

/// Fills the caller's struct up to its size.
template <class T>
void fill(T filled, T* out) {
  filled.size = taken(out, T{}).size;
  std::memcpy(static_cast<void*>(out), &filled, std::min(filled.size, sizeof(T)));
}

/// Writes defaults to the caller's struct of `size` bytes; bytes beyond the known struct become 0.
template <class T>
void fill_defaults(const T& defaults, T* out, std::size_t size) {
  expect(out != nullptr, "expected a struct, found null");
  expect(size >= sizeof size && size < kMostBytes, "expected the size of a struct");
  std::memset(static_cast<void*>(out), 0, size);
  std::memcpy(static_cast<void*>(out), &size, sizeof size);
  fill(defaults, out);
}

/// Element of the caller's array, whose elements have `size` bytes.
template <class T>
T element_of(const T* array, std::size_t size, std::size_t index) {
  T one{};
  std::memcpy(static_cast<void*>(&one), reinterpret_cast<const char*>(array) + index * size,
              std::min(size, sizeof(T)));
  return one;
}
template <class T>
void put_element(const T& one, T* array, std::size_t size, std::size_t index) {
  std::memcpy(reinterpret_cast<char*>(array) + index * size, &one, std::min(size, sizeof(T)));
}

}  // namespace turgor::c
