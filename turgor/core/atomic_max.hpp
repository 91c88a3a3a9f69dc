// The largest and the least of many numbers that threads find at once, the same whoever comes first.
#pragma once

#include <atomic>
#include <bit>
#include <cstdint>

#include "turgor/core/config.hpp"

namespace turgor {

/// Bit patterns of positive numbers are in the order of the numbers, and those of not-a-number come last. The
/// sign is left away.
TURGOR_HD inline std::uint32_t magnitude_bits(float a) {
  return std::bit_cast<std::uint32_t>(a) & 0x7fffffffu;
}

/// largest = max(largest, found)
TURGOR_HD inline void atomic_max(std::uint32_t& largest, std::uint32_t found) {
#ifdef __CUDA_ARCH__
  // Most threads come too late to be the largest: one place of memory takes few atomics a nanosecond.
  if (found > *static_cast<volatile std::uint32_t*>(&largest)) atomicMax(&largest, found);
#else
  const std::atomic_ref<std::uint32_t> shared(largest);
  std::uint32_t seen = shared.load(std::memory_order_relaxed);
  while (seen < found && !shared.compare_exchange_weak(seen, found)) {
  }
#endif
}

/// least = min(least, found)
TURGOR_HD inline void atomic_min(std::uint32_t& least, std::uint32_t found) {
#ifdef __CUDA_ARCH__
  atomicMin(&least, found);
#else
  const std::atomic_ref<std::uint32_t> shared(least);
  std::uint32_t seen = shared.load(std::memory_order_relaxed);
  while (found < seen && !shared.compare_exchange_weak(seen, found)) {
  }
#endif
}

}  // namespace turgor
