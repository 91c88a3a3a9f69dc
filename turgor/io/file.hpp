// Whole files in and out. A file appears under its name only when it is complete: it is written beside it and
// renamed.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "turgor/core/result.hpp"

namespace turgor {

Status write_file(const std::filesystem::path& path, std::string_view bytes);
Result<std::string> read_file(const std::filesystem::path& path);

}  // namespace turgor
