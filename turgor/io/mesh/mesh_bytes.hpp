// Content of a mesh file. Internal to io/.
#pragma once

#include <filesystem>
#include <string>

#include "turgor/core/result.hpp"

namespace turgor::io {

/// Reads the whole mesh file. Error: it does not exist, is a folder or is empty.
Result<std::string> read_mesh_bytes(const std::filesystem::path& path);

}  // namespace turgor::io
