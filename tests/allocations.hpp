// Counts what a thread takes from the heap: for tests of what a tick may not do. A program of tests with
// allocations.cpp in it has its operator new replaced.
#pragma once

#include <cstddef>

namespace turgor::test {

extern thread_local std::size_t allocations;  // of this thread, since it began

/// Number of allocations while `act` runs.
template <class Act>
std::size_t allocations_of(const Act& act) {
  const std::size_t before = allocations;
  act();
  return allocations - before;
}

}  // namespace turgor::test
