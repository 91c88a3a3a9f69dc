// Limits of turgor-read, which reads files that may be made to attack it.
#pragma once

#include <cstddef>

namespace turgor {

/// From here on the process can read files and compute, and nothing else: it cannot write a file, start a
/// process or thread, use a network, or gain rights. `memory`: bytes that it may add to its address space.
/// Kernels without seccomp keep the other limits.
void enter_sandbox(std::size_t memory);

}  // namespace turgor
