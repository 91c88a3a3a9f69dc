#include "turgor/sim/autosave/autosave_folder.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "turgor/io/files/unfinished.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

constexpr const char* kKind = "autosave";

fs::path own_name(const fs::path& goal) {
  static std::atomic<unsigned> count{0};
  fs::path path = hidden_beside(goal, kKind);
  path += fmt::format("-{}", count++);
  return path;
}

/// Hard link, or a copy where there are none.
Status link_or_copy(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::create_directories(to.parent_path(), error);
  fs::create_hard_link(from, to, error);
  if (error) fs::copy_file(from, to, fs::copy_options::overwrite_existing, error);
  if (error) return Error{fmt::format("{}: cannot be kept: {}", from.string(), error.message())};
  return Done{};
}

Status copy_to(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::create_directories(to.parent_path(), error);
  fs::copy_file(from, to, fs::copy_options::overwrite_existing, error);
  if (error) return Error{fmt::format("{}: cannot be copied: {}", from.string(), error.message())};
  return Done{};
}

bool is_kept(const fs::path& file, std::uint64_t size) {
  std::error_code error;
  return fs::is_regular_file(fs::symlink_status(file, error)) && fs::file_size(file, error) == size && !error;
}

/// Time of the state in a folder; the earliest time if it has none.
fs::file_time_type time_of_state(const fs::path& folder) {
  std::error_code error;
  const fs::file_time_type time = fs::last_write_time(folder / "state", error);
  return error ? fs::file_time_type::min() : time;
}

/// A state is bytes of a program's memory: only the user's own is read.
Status check_owner(const fs::path& folder) {
  for (const fs::path& path : {folder, folder / "state"}) {
    struct stat found {};
    if (lstat(path.c_str(), &found) != 0 || S_ISLNK(found.st_mode) || found.st_uid != geteuid() ||
        (found.st_mode & S_IWOTH) != 0)
      return Error{
          fmt::format("{}: the autosave belongs to another user, or others may write it; run without "
                      "--resume to start again",
                      path.string())};
  }
  return Done{};
}

}  // namespace

std::vector<fs::path> autosaves_beside(const fs::path& goal) {
  std::vector<fs::path> found = leftovers_beside(goal, kKind);
  std::sort(found.begin(), found.end(),
            [](const fs::path& a, const fs::path& b) { return time_of_state(a) > time_of_state(b); });
  return found;
}

AutosaveFolder::AutosaveFolder(const fs::path& goal) : goal_(goal), path_(own_name(goal)) {}

AutosaveFolder::AutosaveFolder(AutosaveFolder&& other) noexcept
    : goal_(std::move(other.goal_)),
      path_(std::move(other.path_)),
      lock_(std::exchange(other.lock_, -1)),
      number_(other.number_) {}

AutosaveFolder::~AutosaveFolder() {
  if (lock_ >= 0) close(lock_);
}

Result<std::optional<AutosaveFolder>> AutosaveFolder::take_over(const fs::path& goal) {
  const std::vector<fs::path> found = autosaves_beside(goal);
  if (found.empty() || time_of_state(found[0]) == fs::file_time_type::min())
    return std::optional<AutosaveFolder>();
  if (const Status own = check_owner(found[0]); !own) return own.error();
  AutosaveFolder folder(goal);
  std::error_code error;
  fs::rename(found[0], folder.path_, error);
  if (error)
    return Error{
        fmt::format("{}: the autosave cannot be taken over: {}", found[0].string(), error.message())};
  folder.lock();
  return std::optional(std::move(folder));
}

Status AutosaveFolder::create() {
  if (lock_ >= 0) return Done{};
  std::error_code error;
  fs::create_directory(path_, error);
  if (!error) fs::permissions(path_, fs::perms::owner_all, error);
  if (error) return Error{fmt::format("{}: cannot make the folder: {}", path_.string(), error.message())};
  lock();
  return Done{};
}

void AutosaveFolder::lock() {
  lock_ = open(path_.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC);
  struct flock shared {};
  shared.l_type = F_RDLCK, shared.l_whence = SEEK_SET;
  if (lock_ >= 0) (void)fcntl(lock_, F_OFD_SETLK, &shared);  // without locks the process id must suffice
}

fs::path AutosaveFolder::growing(int number) const { return path_ / fmt::format("growing-{}", number); }

Result<std::vector<SavedFile>> AutosaveFolder::keep_files(const fs::path& results,
                                                          const std::vector<std::string>& grows) {
  if (const Status created = create(); !created) return created.error();
  std::vector<SavedFile> files;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(results, error), end; !error && entry != end;
       entry.increment(error)) {
    if (!entry->is_regular_file(error)) continue;
    const std::string name = entry->path().lexically_relative(results).string();
    SavedFile file{name, entry->file_size(error), std::find(grows.begin(), grows.end(), name) != grows.end()};
    const fs::path kept = path_ / "files" / name;
    Status status = Done{};
    if (file.grows)
      status = copy_to(entry->path(), growing(number_ + 1) / name);
    else if (!is_kept(kept, file.size))
      status = link_or_copy(entry->path(), kept);
    if (!status) return status.error();
    files.push_back(std::move(file));
  }
  if (error) return Error{fmt::format("{}: cannot be listed: {}", results.string(), error.message())};
  return files;
}

Status AutosaveFolder::replace_state() {
  std::error_code error;
  fs::rename(next_state_file(), state_file(), error);
  if (error) return Error{fmt::format("{}: {}", state_file().string(), error.message())};
  fs::remove_all(growing(number_), error);
  number_++;
  return Done{};
}

Status AutosaveFolder::restore_files(const std::vector<SavedFile>& files, const fs::path& results) {
  for (const SavedFile& file : files) {
    const fs::path name(file.name), kept = (file.grows ? growing(number_) : path_ / "files") / name;
    const bool is_inside = name.is_relative() && *name.lexically_normal().begin() != "..";
    if (!is_inside || !is_kept(kept, file.size))
      return Error{
          fmt::format("{}: the autosave is damaged: expected a file of {} bytes; run without --resume to "
                      "start again",
                      kept.string(), file.size)};
    const Status status = file.grows ? copy_to(kept, results / name) : link_or_copy(kept, results / name);
    if (!status) return status;
  }
  return Done{};
}

void AutosaveFolder::remove_all() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  for (const fs::path& folder : autosaves_beside(goal_)) fs::remove_all(folder, ignored);
}

}  // namespace turgor
