#include "turgor/io/file.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>

#include <fmt/format.h>

#include "turgor/io/input_file.hpp"

namespace turgor {

Status write_file(const std::filesystem::path& path, std::string_view bytes) {
  std::filesystem::path partial = path;
  partial += ".partial";
  errno = 0;
  std::ofstream stream(partial, std::ios::binary);
  stream.write(bytes.data(), std::streamsize(bytes.size()));
  stream.close();
  std::error_code error;
  if (stream) std::filesystem::rename(partial, path, error);
  if (stream && !error) return Done{};
  const std::string reason = error ? error.message() : std::strerror(errno);
  std::filesystem::remove(partial, error);
  return Error{fmt::format("{}: cannot write the file: {}", path.string(), reason)};
}

/// As many bytes as the file says it has: some, such as those of /proc, never end.
Result<std::string> read_file(const std::filesystem::path& path) {
  if (Status input = io::check_input(path); !input) return input.error();
  std::error_code error;
  std::string bytes(std::filesystem::file_size(path, error), '\0');
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  stream.read(bytes.data(), std::streamsize(bytes.size()));
  if (stream.is_open() && !stream.bad() && !error) {
    bytes.resize(std::size_t(stream.gcount()));
    return bytes;
  }
  return Error{fmt::format("{}: cannot read the file: {}", path.string(), std::strerror(errno))};
}

}  // namespace turgor
