// Where bodies step.
#pragma once

#include <cstdint>

namespace turgor {

/// Of lattices and cloth. All else is the CPU's.
enum class Device : std::uint8_t { kCpu, kGpu };

}  // namespace turgor
