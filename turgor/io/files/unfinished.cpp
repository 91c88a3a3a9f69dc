#include "turgor/io/files/unfinished.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <mutex>
#include <thread>

#include <fmt/format.h>
#include <unistd.h>

namespace turgor {

namespace {

namespace fs = std::filesystem;

/// Paths that a signal must remove. The lock is held to create, rename or remove one.
struct Open {
  std::mutex mutex;
  std::vector<fs::path> paths;
};
Open& open_now() {
  static Open* open = new Open;  // never destroyed: the signal thread outlives main
  return *open;
}

std::string prefix_of(const fs::path& goal, const std::string& kind) {
  return fmt::format(".{}.{}-", goal.filename().string(), kind);
}

/// Process id in a name ".NAME.KIND-PID" or ".NAME.KIND-PID-N"; 0 in any other name.
pid_t owner_of(const std::string& name, const std::string& prefix) {
  pid_t pid = 0;
  if (!name.starts_with(prefix)) return 0;
  const char* last = name.data() + name.size();
  const auto [end, error] = std::from_chars(name.data() + prefix.size(), last, pid);
  return error == std::errc() && (end == last || *end == '-') ? pid : 0;
}

bool is_alive(pid_t pid) { return kill(pid, 0) == 0 || errno != ESRCH; }

bool is_inside(const fs::path& path, const fs::path& folder) {
  const std::string inner = path.string(), outer = folder.string() + "/";
  return inner.starts_with(outer);
}

[[noreturn]] void remove_all_and_exit() {
  Open& open = open_now();
  const std::lock_guard lock(open.mutex);
  std::error_code error;
  constexpr int kTries = 100;  // other threads may still be writing
  for (const fs::path& path : open.paths)
    for (int i = 0; i < kTries && fs::exists(fs::symlink_status(path, error)); i++)
      fs::remove_all(path, error);
  std::fputs("\nturgor: interrupted; unfinished files were removed, earlier results are unchanged\n", stderr);
  _exit(130);
}

}  // namespace

Unfinished::Unfinished(const fs::path& goal) {
  static std::atomic<unsigned> count{0};
  path_ = hidden_beside(goal, "partial");
  path_ += fmt::format("-{}", count++);
  Open& open = open_now();
  const std::lock_guard lock(open.mutex);
  // Files inside an unfinished folder are removed with the folder.
  const bool inside = std::any_of(open.paths.begin(), open.paths.end(),
                                  [&](const fs::path& folder) { return is_inside(goal, folder); });
  std::error_code ignored;
  if (!inside)
    for (const fs::path& leftover : leftovers_beside(goal, "partial"))
      if (!fs::is_directory(fs::symlink_status(leftover, ignored))) fs::remove(leftover, ignored);
  open.paths.push_back(path_);
}

Unfinished::Unfinished(Unfinished&& other) noexcept : path_(std::exchange(other.path_, fs::path())) {}

Unfinished::~Unfinished() {
  if (path_.empty()) return;
  const std::lock_guard lock(open_now().mutex);
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  std::erase(open_now().paths, path_);
}

Status Unfinished::keep(const std::function<Status()>& give_name) {
  const std::lock_guard lock(open_now().mutex);
  if (Status named = give_name(); !named) return named;
  std::erase(open_now().paths, path_);
  path_.clear();
  return Done{};
}

Result<fs::path> resolved_goal(const fs::path& goal) {
  std::error_code error;
  fs::path plain = fs::absolute(goal, error).lexically_normal();
  if (!plain.has_filename()) plain = plain.parent_path();  // "out/" is "out"
  const fs::path resolved = fs::weakly_canonical(plain, error);
  if (error) return Error{fmt::format("{}: cannot be reached: {}", goal.string(), error.message())};
  if (fs::is_symlink(fs::symlink_status(resolved, error)))
    return Error{fmt::format("{}: is a link to {}, which does not exist", goal.string(),
                             fs::read_symlink(resolved, error).string())};
  return resolved;
}

std::vector<fs::path> leftovers_beside(const fs::path& goal, const std::string& kind) {
  const fs::path folder = goal.has_parent_path() ? goal.parent_path() : fs::path(".");
  const std::string prefix = prefix_of(goal, kind);
  std::vector<fs::path> leftovers;
  std::error_code ignored;
  for (fs::directory_iterator entry(folder, ignored), end; entry != end; entry.increment(ignored))
    if (const pid_t owner = owner_of(entry->path().filename().string(), prefix);
        owner > 0 && !is_alive(owner))
      leftovers.push_back(entry->path());
  return leftovers;
}

fs::path hidden_beside(const fs::path& goal, const std::string& kind) {
  return goal.parent_path() / fmt::format("{}{}", prefix_of(goal, kind), getpid());
}

void remove_unfinished_when_interrupted() {
  // An empty handler instead of SIG_IGN: child programs then start with the default action.
  for (const int signal : {SIGPIPE, SIGXFSZ}) {
    struct sigaction now {};
    if (sigaction(signal, nullptr, &now) == 0 && now.sa_handler == SIG_IGN) continue;
    now.sa_handler = [](int) {};
    now.sa_flags = SA_RESTART;
    sigaction(signal, &now, nullptr);
  }
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) {
    struct sigaction now {};
    const bool ignored = sigaction(signal, nullptr, &now) == 0 && now.sa_handler == SIG_IGN;  // as by nohup
    if (!ignored) sigaddset(&signals, signal);
  }
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread([signals] {
    int signal = 0;
    while (sigwait(&signals, &signal) != 0) continue;
    remove_all_and_exit();
  }).detach();
}

}  // namespace turgor
