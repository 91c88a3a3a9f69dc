// Results that are copied to a buffer of the caller.
#pragma once

#include <algorithm>

#include "c/guard.hpp"

namespace turgor::c {

/// Copies `count` values. `written` (may be null) receives the count, even if it exceeds the capacity.
template <class T>
void copy_out(const T* values, std::size_t count, T* buffer, std::size_t capacity, std::size_t* written) {
  if (written) *written = count;
  expect(buffer != nullptr || count == 0, "expected a buffer, found null");
  expect(capacity >= count, "expected a buffer for all values, found a smaller one");
  std::copy_n(values, count, buffer);
}

}  // namespace turgor::c
