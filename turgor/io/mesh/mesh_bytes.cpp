#include "turgor/io/mesh/mesh_bytes.hpp"

#include <fmt/format.h>

#include "turgor/io/files/file.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

Result<std::string> read_mesh_bytes(const fs::path& path) {
  std::error_code failed;
  if (fs::is_directory(path, failed))
    return Error{fmt::format("{}: expected a mesh file, found a folder", path.string())};
  Result<std::string> bytes = read_file(path);
  if (bytes && bytes->empty())
    return Error{fmt::format("{}: expected a mesh file, found an empty file", path.string())};
  return bytes;
}

}  // namespace turgor::io
