#include "turgor/io/files/file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "turgor/io/files/input_file.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

bool is_standard_output(const fs::path& path) {
  struct stat file {
  }, output{};
  return stat(path.c_str(), &file) == 0 && fstat(STDOUT_FILENO, &output) == 0 &&
         file.st_dev == output.st_dev && file.st_ino == output.st_ino;
}

/// Target path with its links resolved, if a file may be written to it.
Result<fs::path> file_goal(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error) || !path.has_filename())
    return Error{fmt::format("{}: is a folder; expected the name of a file", path.string())};
  // Names of open files, such as /dev/stdout, link to objects without a path: such links are not followed.
  const fs::file_status status = fs::status(path, error);
  if (fs::exists(status) && !fs::is_regular_file(status)) return path;
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (!fs::exists(folder, error))
    return Error{fmt::format("{}: the folder {} does not exist", path.string(), folder.string())};
  if (!fs::is_directory(folder, error))
    return Error{fmt::format("{}: {} is not a folder", path.string(), folder.string())};
  if (fs::exists(status) && access(path.c_str(), W_OK) != 0)
    return Error{fmt::format("{}: cannot write the file: {}", path.string(), std::strerror(errno))};
  if (is_standard_output(path))
    return Error{fmt::format("{}: is standard output; expected another file", path.string())};
  return resolved_goal(path);
}

}  // namespace

Result<FileWriter> FileWriter::create(const fs::path& path) {
  const Result<fs::path> goal = file_goal(path);
  if (!goal) return goal.error();
  FileWriter file(path, *goal);
  struct stat earlier {};
  const bool exists = stat(goal->c_str(), &earlier) == 0;
  if (exists && !S_ISREG(earlier.st_mode)) {
    file.descriptor_ = open(goal->c_str(), O_WRONLY | O_CLOEXEC);
  } else {
    file.partial_.emplace(*goal);
    file.descriptor_ = open(file.partial_->path().c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  }
  if (file.descriptor_ < 0) return file.error(errno);
  if (file.partial_) file.partial_->hold();
  if (exists && file.partial_)
    fchmod(file.descriptor_, earlier.st_mode & 07777);  // keeps the permissions of the replaced file
  return file;
}

FileWriter::FileWriter(FileWriter&& other) noexcept
    : path_(std::move(other.path_)),
      goal_(std::move(other.goal_)),
      partial_(std::move(other.partial_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      failure_(other.failure_) {}

FileWriter::~FileWriter() {
  if (descriptor_ >= 0) close(descriptor_);
}

Error FileWriter::error(int number) const {
  return {fmt::format("{}: cannot write the file: {}", path_.string(), std::strerror(number))};
}

void FileWriter::write(std::string_view bytes) {
  constexpr std::size_t kMost = std::size_t{1} << 30;  // largest write of Linux
  while (!bytes.empty() && failure_ == 0) {
    const ssize_t size = ::write(descriptor_, bytes.data(), std::min(bytes.size(), kMost));
    if (size >= 0)
      bytes.remove_prefix(std::size_t(size));
    else if (errno != EINTR)
      failure_ = errno;
  }
}

Status FileWriter::commit() {
  if (close(std::exchange(descriptor_, -1)) != 0 && failure_ == 0) failure_ = errno;
  if (failure_ != 0) return error(failure_);
  if (!partial_) return Done{};
  return partial_->keep([this]() -> Result<fs::path> {
    if (rename(partial_->path().c_str(), goal_.c_str()) != 0) return error(errno);
    return goal_;
  });
}

Status check_file_goal(const fs::path& path) {
  if (const Result<fs::path> goal = file_goal(path); !goal) return goal.error();
  return Done{};
}

Status write_file(const fs::path& path, std::string_view bytes) {
  Result<FileWriter> file = FileWriter::create(path);
  if (!file) return file.error();
  file->write(bytes);
  return file->commit();
}

/// Reads as many bytes as the file size says, because some files, such as those of /proc, never end.
Result<std::string> read_file(const fs::path& path) {
  if (Status input = io::check_input(path); !input) return input.error();
  std::error_code error;
  std::string bytes(fs::file_size(path, error), '\0');
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
