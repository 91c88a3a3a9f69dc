// Limit of the number of threads that a user may ask for.
#pragma once

#include <string>

#include "turgor/core/result.hpp"

namespace turgor {

constexpr int kMostThreads = 1024;  // a task arena of oneTBB fails with more than a few thousand

/// Error: a number outside 0 (one per core) to kMostThreads.
inline Status check_threads(int threads) {
  if (threads >= 0 && threads <= kMostThreads) return Done{};
  return Error{"expected a number of threads from 0 (one per core) to " + std::to_string(kMostThreads) +
               ", found " + std::to_string(threads)};
}

}  // namespace turgor
