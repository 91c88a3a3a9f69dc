// Names of files in sentences: what may have been meant when a file is not there.
#pragma once

#include <filesystem>
#include <string>

namespace turgor::io {

/// "ct.nii: does not exist; did you mean ct.nii.gz?"
std::string not_found(const std::filesystem::path& path);

}  // namespace turgor::io
