#include "turgor/io/files/unfinished.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <mutex>
#include <optional>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "turgor/core/plain_text.hpp"
#include "turgor/core/start_thread.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

/// Paths that a signal must remove, and those that this process has completed. The lock is held to create,
/// rename or remove one.
struct Open {
  std::mutex mutex;
  std::vector<fs::path> paths;
  std::vector<fs::path> complete;  // the newest kMostNamed
  std::string sentence;            // say_when_interrupted
};
constexpr std::size_t kMostNamed = 3;
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

/// Seconds of a clock of the system.
double seconds_of(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

/// Fields of /proc/PID/stat.
struct ProcessState {
  char state = 0;       // 'Z' for a zombie
  double started = -1;  // since the machine started [s]
};

/// Nothing without such a process, or without /proc.
std::optional<ProcessState> process_state(pid_t pid) {
  FILE* file = std::fopen(fmt::format("/proc/{}/stat", pid).c_str(), "re");
  if (!file) return {};
  char text[1024] = {};
  const std::size_t size = std::fread(text, 1, sizeof text - 1, file);
  std::fclose(file);
  // the program's name, in parentheses, may contain any character
  const std::string_view line(text, size);
  const std::size_t end = line.rfind(')');
  ProcessState process;
  unsigned long long ticks = 0;
  constexpr const char* kFields =  // the state is field 3, the start is field 22
      " %c %*d %*d %*d %*d %*d %*u %*u %*u %*u %*u %*u %*u %*d %*d %*d %*d %*d %*d %llu";
  if (end == line.npos || std::sscanf(text + end + 1, kFields, &process.state, &ticks) != 2) return {};
  process.started = double(ticks) / double(sysconf(_SC_CLK_TCK));
  return process;
}

/// True if a process with this id runs and started before `changed`, the time of a file's last change.
bool has_run_since(pid_t pid, double changed) {
  if (kill(pid, 0) != 0 && errno == ESRCH) return false;
  const std::optional<ProcessState> process = process_state(pid);
  if (!process) return true;  // no /proc: any process with the id counts
  if (process->state == 'Z' || process->state == 'X') return false;
  constexpr double kClockError = 1;  // [s]
  const double started = seconds_of(CLOCK_REALTIME) - seconds_of(CLOCK_BOOTTIME) + process->started;
  return started <= changed + kClockError;
}

struct flock whole_file(short type) {
  struct flock range {};
  range.l_type = type, range.l_whence = SEEK_SET;
  return range;
}

/// True if no process holds the lock, and the owner has ended. The owner counts too, because a file is
/// created before it is locked, and some file systems have no locks.
bool is_abandoned(const fs::path& path, pid_t owner) {
  struct stat found {};
  if (lstat(path.c_str(), &found) != 0) return false;
  const int file = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOFOLLOW | O_CLOEXEC);
  struct flock other = whole_file(F_WRLCK);
  const bool locked = file >= 0 && fcntl(file, F_OFD_GETLK, &other) == 0 && other.l_type != F_UNLCK;
  if (file >= 0) close(file);
  return !locked &&
         !has_run_since(owner, double(found.st_ctim.tv_sec) + 1e-9 * double(found.st_ctim.tv_nsec));
}

/// Abandoned files of a folder. prefix_of_name(name): what precedes the owner's process id in a name; "/" for
/// other files.
template <class PrefixOfName>
std::vector<fs::path> leftovers(const fs::path& folder, const PrefixOfName& prefix_of_name) {
  std::vector<fs::path> found;
  std::error_code ignored;
  for (fs::directory_iterator entry(folder, ignored), end; entry != end; entry.increment(ignored)) {
    const std::string name = entry->path().filename().string();
    const pid_t owner = owner_of(name, prefix_of_name(name));
    if (owner > 0 && is_abandoned(entry->path(), owner)) found.push_back(entry->path());
  }
  return found;
}

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
  const std::string besides = open.sentence.empty() ? "" : "; " + on_one_line(open.sentence);
  if (open.complete.empty()) {
    std::fprintf(stderr,
                 "\nturgor: interrupted; unfinished files were removed, earlier results are unchanged%s\n",
                 besides.c_str());
  } else {
    std::vector<std::string> names;
    for (const fs::path& path : open.complete) names.push_back(path.string());
    const std::string named = fmt::format("{}", fmt::join(names, ", "));
    std::fprintf(stderr, "\nturgor: interrupted; complete: %s; unfinished files were removed%s\n",
                 on_one_line(named).c_str(), besides.c_str());
  }
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

Unfinished::Unfinished(Unfinished&& other) noexcept
    : path_(std::exchange(other.path_, fs::path())), lock_(std::exchange(other.lock_, -1)) {}

Unfinished::~Unfinished() {
  if (path_.empty()) return;
  const std::lock_guard lock(open_now().mutex);
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  std::erase(open_now().paths, path_);
  let_go();
}

void Unfinished::hold() {
  // a shared lock needs no right to write, which folders do not give
  lock_ = open(path_.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC);
  struct flock shared = whole_file(F_RDLCK);
  if (lock_ >= 0 && fcntl(lock_, F_OFD_SETLK, &shared) != 0) let_go();  // the process id must suffice
}

void Unfinished::let_go() {
  if (lock_ >= 0) close(lock_);
  lock_ = -1;
}

Status Unfinished::keep(const std::function<Result<fs::path>()>& give_name) {
  Open& open = open_now();
  const std::lock_guard lock(open.mutex);
  const Result<fs::path> name = give_name();
  if (!name) return name.error();
  std::erase(open.paths, path_);
  path_.clear();
  let_go();
  // files inside an unfinished folder are not complete before the folder is
  const bool inside = std::any_of(open.paths.begin(), open.paths.end(),
                                  [&](const fs::path& folder) { return is_inside(*name, folder); });
  if (inside) return Done{};
  std::erase(open.complete, *name);
  open.complete.push_back(*name);
  if (open.complete.size() > kMostNamed) open.complete.erase(open.complete.begin());
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
  return leftovers(folder, [prefix = prefix_of(goal, kind)](const std::string&) { return prefix; });
}

std::vector<fs::path> leftovers_in(const fs::path& folder) {
  return leftovers(folder, [](const std::string& name) {
    constexpr std::string_view kMark = ".partial-";
    const std::size_t mark = name.rfind(kMark);
    return name.starts_with('.') && mark != name.npos ? name.substr(0, mark + kMark.size()) : "/";
  });
}

fs::path hidden_beside(const fs::path& goal, const std::string& kind) {
  return goal.parent_path() / fmt::format("{}{}", prefix_of(goal, kind), getpid());
}

fs::path unused_name_beside(const fs::path& goal, const std::string& kind) {
  std::error_code ignored;
  for (int n = 1;; n++) {
    const std::string number = n == 1 ? "" : fmt::format("-{}", n);
    fs::path name = goal.parent_path() / fmt::format("{}.{}{}", goal.filename().string(), kind, number);
    if (!fs::exists(fs::symlink_status(name, ignored))) return name;
  }
}

void say_when_interrupted(std::string sentence) {
  const std::lock_guard lock(open_now().mutex);
  open_now().sentence = std::move(sentence);
}

void remove_unfinished_when_interrupted() {
  {
    const std::lock_guard lock(open_now().mutex);
    open_now().complete.clear();  // what another program completed before it became this one by a fork
  }
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
  Result<std::thread> waiting = start_thread("the signals", [signals] {
    int signal = 0;
    while (sigwait(&signals, &signal) != 0) continue;
    remove_all_and_exit();
  });
  if (waiting)
    waiting->detach();
  else  // signals end the program, and the next one removes its unfinished files
    pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
}

}  // namespace turgor
