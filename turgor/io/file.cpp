#include "turgor/io/file.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include <fmt/format.h>

#include "turgor/io/names.hpp"

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

Result<std::string> read_file(const std::filesystem::path& path) {
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (stream.is_open() && !stream.bad()) return bytes;
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return Error{io::not_found(path)};
  return Error{fmt::format("{}: cannot read the file: {}", path.string(), std::strerror(errno))};
}

}  // namespace turgor
