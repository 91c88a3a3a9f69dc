// Reading of files whose content may need more memory than there is.
#pragma once

#include <filesystem>
#include <new>

#include <fmt/format.h>

#include "turgor/core/result.hpp"

namespace turgor::io {

/// Result of `read`, which reads this file. Error instead of std::bad_alloc, with the name of the file.
template <class Read>
auto within_memory(const std::filesystem::path& path, const Read& read) -> decltype(read()) {
  try {
    return read();
  } catch (const std::bad_alloc&) {
    return Error{fmt::format("{}: cannot be read: not enough memory", path.string())};
  }
}

}  // namespace turgor::io
