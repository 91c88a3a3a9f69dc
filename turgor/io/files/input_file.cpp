#include "turgor/io/files/input_file.hpp"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "turgor/io/files/names.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

const char* kind(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  if (S_ISCHR(mode) || S_ISBLK(mode)) return "a device";
  return S_ISREG(mode) ? "a file" : "something else";
}

Error cannot_open(const fs::path& path, int reason) {
  if (reason == ENOENT || reason == ENOTDIR) return {not_found(path)};
  if (reason == EACCES || reason == EPERM)
    return {
        fmt::format("{}: permission denied: the file or a folder above it may not be read", path.string())};
  return {fmt::format("{}: cannot be opened: {}", path.string(), std::strerror(reason))};
}

Status check(const fs::path& path, bool wants_folder) {
  struct stat found {};
  if (stat(path.c_str(), &found) != 0) {
    const int reason = errno;
    if (reason == ENOENT && lstat(path.c_str(), &found) == 0)
      return Error{fmt::format("{}: is a link to a file that does not exist", path.string())};
    return cannot_open(path, reason);
  }
  if (wants_folder ? !S_ISDIR(found.st_mode) : !S_ISREG(found.st_mode))
    return Error{fmt::format("{}: is {}; expected {}", path.string(), kind(found.st_mode),
                             wants_folder ? "a folder" : "a file")};
  const int file = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return cannot_open(path, errno);
  close(file);
  return Done{};
}

}  // namespace

Status check_input(const fs::path& path) { return check(path, false); }
Status check_input_folder(const fs::path& path) { return check(path, true); }

}  // namespace turgor::io
