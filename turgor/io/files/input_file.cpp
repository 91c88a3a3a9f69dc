#include "turgor/io/files/input_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iterator>

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/magic.h>
#include <sys/stat.h>
#include <sys/vfs.h>
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

/// Files of the kernel, such as /proc/kmsg, look like plain ones, but reading them may wait for ever.
bool is_of_kernel(const fs::path& path) {
  struct statfs system {};
  if (statfs(path.c_str(), &system) != 0) return false;
  constexpr decltype(system.f_type) kPseudo[] = {PROC_SUPER_MAGIC, SYSFS_MAGIC, DEBUGFS_MAGIC, TRACEFS_MAGIC};
  return std::find(std::begin(kPseudo), std::end(kPseudo), system.f_type) != std::end(kPseudo);
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
  if (is_of_kernel(path))
    return Error{fmt::format("{}: is a file of the kernel, which may never end; expected a file on a disk",
                             path.string())};
  const int file = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return cannot_open(path, errno);
  close(file);
  return Done{};
}

}  // namespace

Status check_input(const fs::path& path) { return check(path, false); }
Status check_input_folder(const fs::path& path) { return check(path, true); }

}  // namespace turgor::io
