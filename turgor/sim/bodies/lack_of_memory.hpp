// Note of a body whose steps have moved from a GPU to the host.
#pragma once

#include <string>

#include <fmt/format.h>

namespace turgor {

/// `time`: beginning of the frame [s].
inline std::string note_of_lacking_memory(double time) {
  return fmt::format(
      "steps on the host since {:.4g} s: the GPU lacks memory for contacts, cuts or its solver", time);
}

}  // namespace turgor
