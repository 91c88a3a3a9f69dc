// Where bodies step.
#pragma once

#include <cstdint>

namespace turgor {

/// Lattices and cloth; Green's functions of sfem bodies are computed there. All else is the CPU's.
enum class Device : std::uint8_t { kCpu, kGpu };

}  // namespace turgor
