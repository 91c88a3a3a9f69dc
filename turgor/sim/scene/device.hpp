// Device on which bodies step.
#pragma once

#include <cstdint>

namespace turgor {

/// Device of lattices and cloth, and of the Green's functions of sfem bodies. All other work runs on the CPU.
enum class Device : std::uint8_t { kCpu, kGpu };

}  // namespace turgor
