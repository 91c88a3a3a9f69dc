#include "turgor/sim/output_folder.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

namespace turgor {

namespace {

namespace fs = std::filesystem;

/// Folders that a signal must remove. Whoever renames or removes one holds the lock.
struct Open {
  std::mutex mutex;
  std::vector<fs::path> folders;
};
Open& open_folders() {
  static Open* open = new Open;  // never destroyed: the signal thread outlives main
  return *open;
}

void forget(const fs::path& folder) { std::erase(open_folders().folders, folder); }

fs::path sibling(const fs::path& goal, const char* kind) {
  return goal.parent_path() / fmt::format(".{}.{}-{}", goal.filename().string(), kind, getpid());
}

/// The process that left a sibling named ".NAME.KIND-PID", or 0.
pid_t owner_of(const fs::path& path, const fs::path& goal, const char* kind) {
  const std::string name = path.filename().string(),
                    prefix = fmt::format(".{}.{}-", goal.filename().string(), kind);
  pid_t pid = 0;
  if (!name.starts_with(prefix)) return 0;
  const auto [end, error] = std::from_chars(name.data() + prefix.size(), name.data() + name.size(), pid);
  return error == std::errc() && end == name.data() + name.size() ? pid : 0;
}

bool is_alive(pid_t pid) { return kill(pid, 0) == 0 || errno != ESRCH; }

/// Removes what killed runs left, and brings back an earlier result that one had moved aside.
void clean_up(const fs::path& goal) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(goal.parent_path(), error)) {
    const pid_t partial = owner_of(entry.path(), goal, "partial"), old = owner_of(entry.path(), goal, "old");
    if (partial > 0 && !is_alive(partial)) fs::remove_all(entry.path(), error);
    if (old <= 0 || is_alive(old)) continue;
    if (fs::exists(goal, error))
      fs::remove_all(entry.path(), error);
    else
      fs::rename(entry.path(), goal, error);
  }
}

Status check_goal(const fs::path& goal) {
  std::error_code error;
  if (!fs::exists(goal, error)) return Done{};
  if (!fs::is_directory(goal, error))
    return Error{fmt::format("{}: expected a folder for the results, found a file", goal.string())};
  if (fs::is_empty(goal, error) || fs::exists(goal / kReportFile, error)) return Done{};
  return Error{
      fmt::format("{}: the folder is not empty and is not the output of a run (it has no {}); choose another "
                  "one with --out",
                  goal.string(), kReportFile)};
}

/// Gives `partial` the name of `goal`; the earlier goal, if any, ends at the returned path, to be deleted.
Result<fs::path> swap_in(const fs::path& partial, const fs::path& goal) {
  std::error_code error;
  if (!fs::exists(goal, error)) {
    fs::rename(partial, goal, error);
    if (!error) return fs::path();
    return Error{fmt::format("{}: cannot give the results their name: {}", goal.string(), error.message())};
  }
  // One atomic exchange where the file system can.
  if (renameat2(AT_FDCWD, partial.c_str(), AT_FDCWD, goal.c_str(), RENAME_EXCHANGE) == 0) return partial;
  const fs::path old = sibling(goal, "old");
  fs::rename(goal, old, error);
  if (!error) fs::rename(partial, goal, error);
  if (!error) return old;
  std::error_code ignored;
  if (!fs::exists(goal, ignored)) fs::rename(old, goal, ignored);
  return Error{fmt::format("{}: cannot replace the earlier results: {}", goal.string(), error.message())};
}

[[noreturn]] void remove_folders_and_exit() {
  Open& open = open_folders();
  const std::lock_guard lock(open.mutex);
  std::error_code error;
  constexpr int kTries = 100;  // other threads may still be writing
  for (const fs::path& folder : open.folders)
    for (int i = 0; i < kTries && fs::exists(folder, error); i++) fs::remove_all(folder, error);
  std::fputs("\nturgor: interrupted; nothing was left behind, earlier results are untouched\n", stderr);
  std::fflush(nullptr);
  _exit(130);
}

}  // namespace

Result<OutputFolder> OutputFolder::create(const fs::path& wanted) {
  std::error_code error;
  fs::path plain = fs::absolute(wanted, error).lexically_normal();
  if (!plain.has_filename()) plain = plain.parent_path();  // "out/" is "out"
  const fs::path goal = fs::weakly_canonical(plain, error);
  if (error || !goal.has_filename())
    return Error{fmt::format("{}: expected the name of a folder for the results", wanted.string())};
  fs::create_directories(goal.parent_path(), error);
  if (error)
    return Error{fmt::format("{}: cannot make the folder: {}", goal.parent_path().string(), error.message())};
  clean_up(goal);
  if (const Status status = check_goal(goal); !status) return status.error();
  const fs::path partial = sibling(goal, "partial");
  const std::lock_guard lock(open_folders().mutex);
  fs::remove_all(partial, error);
  if (!fs::create_directory(partial, error))
    return Error{fmt::format("{}: cannot make the folder: {}", partial.string(), error.message())};
  open_folders().folders.push_back(partial);
  return OutputFolder(goal, partial);
}

OutputFolder::OutputFolder(fs::path goal, fs::path partial)
    : goal_(std::move(goal)), partial_(std::move(partial)) {}
OutputFolder::OutputFolder(OutputFolder&& other) noexcept
    : goal_(std::move(other.goal_)), partial_(std::exchange(other.partial_, fs::path())) {}

OutputFolder::~OutputFolder() {
  if (partial_.empty()) return;
  const std::lock_guard lock(open_folders().mutex);
  std::error_code error;
  fs::remove_all(partial_, error);
  forget(partial_);
}

Status OutputFolder::commit() {
  const std::lock_guard lock(open_folders().mutex);
  const Result<fs::path> old = swap_in(partial_, goal_);
  if (!old) return old.error();
  std::error_code error;
  if (!old->empty()) fs::remove_all(*old, error);
  forget(partial_);
  partial_.clear();
  return Done{};
}

void remove_partial_folders_when_interrupted() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread([signals] {
    int signal = 0;
    sigwait(&signals, &signal);
    remove_folders_and_exit();
  }).detach();
}

}  // namespace turgor
