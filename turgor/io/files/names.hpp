// Suggestions for file names that do not exist.
#pragma once

#include <filesystem>
#include <string>

namespace turgor::io {

/// "ct.nii: does not exist; did you mean ct.nii.gz?"
std::string not_found(const std::filesystem::path& path);

}  // namespace turgor::io
