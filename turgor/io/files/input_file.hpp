// What every reader asks of a path before it opens it: a pipe would be waited for, a device never ends, and
// "no permission" is not "does not exist". Internal to the library.
#pragma once

#include <filesystem>

#include "turgor/core/result.hpp"

namespace turgor::io {

/// A regular file that can be opened; the error says what else it is. Never waits.
Status check_input(const std::filesystem::path& path);
/// The same of a folder whose names can be listed.
Status check_input_folder(const std::filesystem::path& path);

}  // namespace turgor::io
