// Counts what is allocated, by a replaced operator new: for tests of what a tick may not do.
#pragma once

#include <cstddef>

namespace turgor::haptics {

/// By the calling thread, so far.
std::size_t allocations();

}  // namespace turgor::haptics
