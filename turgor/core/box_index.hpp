// Index along each axis of sample n in a box of samples, x fastest.
#pragma once

#include <cstdint>

#include "turgor/core/vec.hpp"

namespace turgor {

/// GPUs have no division. That of 64-bit numbers takes a hundred instructions, that of 32-bit ones twenty.
TURGOR_HD inline Int3 box_index(Int3 size, std::size_t n) {
  if (n >> 32 == 0) {
    const auto index = std::uint32_t(n), x = std::uint32_t(size.x), y = std::uint32_t(size.y);
    const std::uint32_t row = index / x;
    return {int(index - row * x), int(row % y), int(row / y)};
  }
  const auto x = std::size_t(size.x), y = std::size_t(size.y);
  return {int(n % x), int(n / x % y), int(n / x / y)};
}

}  // namespace turgor
