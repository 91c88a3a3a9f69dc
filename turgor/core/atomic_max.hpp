// Maximum, minimum, sum and counter that many threads update at once. Maximum, minimum and sum do not depend
// on the order of the threads; values of the counter do.
#pragma once

#include <atomic>
#include <bit>
#include <cstdint>

#include "turgor/core/config.hpp"

namespace turgor {

/// Bits of |a|. Bit patterns of positive floats are ordered like the floats, and those of NaN come last.
TURGOR_HD inline std::uint32_t magnitude_bits(float a) {
  return std::bit_cast<std::uint32_t>(a) & 0x7fffffffu;
}

/// largest = max(largest, found)
TURGOR_HD inline void atomic_max(std::uint32_t& largest, std::uint32_t found) {
#ifdef __CUDA_ARCH__
  // Most threads find a smaller value. The plain read avoids atomics, which are slow on one address.
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

/// sum += more
TURGOR_HD inline void atomic_add(std::uint64_t& sum, std::uint64_t more) {
#ifdef __CUDA_ARCH__
  atomicAdd(reinterpret_cast<unsigned long long*>(&sum), static_cast<unsigned long long>(more));
#else
  std::atomic_ref<std::uint64_t>(sum).fetch_add(more, std::memory_order_relaxed);
#endif
}

/// n++
TURGOR_HD inline int atomic_next(int& n) {
#ifdef __CUDA_ARCH__
  return atomicAdd(&n, 1);
#else
  return std::atomic_ref<int>(n).fetch_add(1, std::memory_order_relaxed);
#endif
}

/// Loads a value that other threads may write at the same time.
TURGOR_HD inline std::uint32_t shared_load(std::uint32_t& value) {
#ifdef __CUDA_ARCH__
  return *static_cast<volatile std::uint32_t*>(&value);
#else
  return std::atomic_ref<std::uint32_t>(value).load(std::memory_order_relaxed);
#endif
}
TURGOR_HD inline void shared_store(std::uint32_t& value, std::uint32_t now) {
#ifdef __CUDA_ARCH__
  *static_cast<volatile std::uint32_t*>(&value) = now;
#else
  std::atomic_ref<std::uint32_t>(value).store(now, std::memory_order_relaxed);
#endif
}

}  // namespace turgor
