// Checks of a path before a reader opens it. A pipe would block, a device never ends, and "no permission" is
// different from "does not exist". Internal to the library.
#pragma once

#include <filesystem>

#include "turgor/core/result.hpp"

namespace turgor::io {

/// A regular file that can be opened; the error names the actual kind. Never blocks.
Status check_input(const std::filesystem::path& path);
/// A folder whose entries can be listed.
Status check_input_folder(const std::filesystem::path& path);

}  // namespace turgor::io
