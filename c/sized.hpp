// Structs of callers that were compiled with an older or a newer header: what both know is copied, the rest
// is as by default, or left alone.
#pragma once

#include <algorithm>
#include <cstring>

#include "c/guard.hpp"

namespace turgor::c {

/// The caller's struct as this library knows it. `size` is its first member.
template <class T>
T taken(const T* given, T defaults) {
  expect(given != nullptr, "expected a struct, found null");
  std::size_t size = 0;
  std::memcpy(&size, given, sizeof size);
  expect(size >= sizeof size && size < (std::size_t(1) << 16), "expected a struct that begins with its size");
  std::memcpy(static_cast<void*>(&defaults), given, std::min(size, sizeof(T)));
  defaults.size = size;
  return defaults;
}

/// Fills the caller's struct as far as it goes; its size stays.
template <class T>
void give(T filled, T* out) {
  filled.size = taken(out, T{}).size;
  std::memcpy(static_cast<void*>(out), &filled, std::min(filled.size, sizeof(T)));
}

/// An element of the caller's array, whose elements are `size` bytes.
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
