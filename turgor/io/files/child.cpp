#include "turgor/io/files/child.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <thread>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace turgor::io {

void lower_limit(int resource, unsigned long long most, unsigned long long grace) {
  rlimit limit{};
  if (getrlimit(__rlimit_resource_t(resource), &limit) != 0) return;
  limit.rlim_cur = std::min(limit.rlim_cur, rlim_t(most));
  limit.rlim_max = std::min(limit.rlim_max, rlim_t(most + grace));
  setrlimit(__rlimit_resource_t(resource), &limit);
}

namespace {

constexpr int kFailed = 255;

/// Blocks all signals until the child has reset its parent's handlers.
class SignalsBlocked {
 public:
  SignalsBlocked() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~SignalsBlocked() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  SignalsBlocked(const SignalsBlocked&) = delete;
  SignalsBlocked& operator=(const SignalsBlocked&) = delete;

 private:
  sigset_t before_;
};

void forget_signals() {
  struct sigaction usual {};
  usual.sa_handler = SIG_DFL;
  for (int signal = 1; signal < NSIG; signal++) sigaction(signal, &usual, nullptr);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
}

void take_limits(const ChildLimits& limits) {
  lower_limit(RLIMIT_CORE, 0);
  lower_limit(RLIMIT_AS, limits.memory);
  lower_limit(RLIMIT_CPU, rlim_t(std::ceil(limits.processor_seconds)), 5);
}

void redirect(int stream, const char* file, int flags) {
  const int opened = open(file, flags, 0600);
  if (opened < 0 || opened == stream) return;
  dup2(opened, stream);
  close(opened);
}

void take_streams(const char* log) {
  redirect(STDIN_FILENO, "/dev/null", O_RDONLY);
  redirect(STDOUT_FILENO, "/dev/null", O_WRONLY);
  redirect(STDERR_FILENO, log, O_WRONLY | O_CREAT | O_TRUNC);
}

/// The descriptors that a program gets: three streams, then `shared` as kSharedFile.
void pass_descriptors(int shared) {
  close_range(STDERR_FILENO + 1, ~0u, CLOSE_RANGE_CLOEXEC);
  if (shared == kSharedFile) fcntl(shared, F_SETFD, 0);
  if (shared >= 0 && shared != kSharedFile) dup2(shared, kSharedFile);
}

ChildEnd end_of(int status) {
  if (WIFSIGNALED(status)) return {ChildEnd::Kind::kCrashed, WTERMSIG(status)};
  return {ChildEnd::Kind::kExited, WEXITSTATUS(status)};
}

/// Records how a child ended, if it has.
bool collect(const Child& child, ChildEnd& end, int flags) {
  int status = 0;
  pid_t found = 0;
  do found = waitpid(child.id, &status, flags);
  while (found < 0 && errno == EINTR);
  if (found > 0) end = end_of(status);
  if (found < 0) end = {ChildEnd::Kind::kNotStarted, errno};
  return found != 0;
}

void stop(const Child& child, ChildEnd& end) {
  if (kill(-child.id, SIGKILL) != 0) kill(child.id, SIGKILL);
  collect(child, end, 0);
  end.kind = ChildEnd::Kind::kTooLong;
}

struct Starting {
  char* const* arguments;
  const char *folder, *log;
  const ChildLimits& limits;
  int shared, report;  // report: a pipe that carries errno if the program cannot be started
  pid_t parent;
};

[[noreturn]] void give_up(int report) {
  const int error = errno;
  const auto written = write(report, &error, sizeof error);
  (void)written;
  _exit(kFailed);
}

/// The child's steps. It shares the memory of its parent, whose other threads run on, so it makes system
/// calls only: no allocation, no lock, no library.
[[noreturn]] void become_program(const Starting& start) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != start.parent) _exit(kFailed);  // the parent has ended already
  setpgid(0, 0);                                  // stopped together with its own children
  forget_signals();
  take_limits(start.limits);
  if (chdir(start.folder) != 0) give_up(start.report);
  take_streams(start.log);
  const int report = fcntl(start.report, F_DUPFD_CLOEXEC, kSharedFile + 1);  // not overwritten by `shared`
  pass_descriptors(start.shared);
  execvp(start.arguments[0], start.arguments);
  give_up(report);
}

/// fork would copy the page tables of gigabytes and run the handlers that libraries have registered for it.
[[gnu::noinline]] pid_t start(const Starting& starting) {
  const pid_t id =
      vfork();  // NOLINT(clang-analyzer-security.insecureAPI.vfork): the child makes system calls only
  if (id == 0) become_program(starting);
  return id;
}

}  // namespace

std::string describe(const ChildEnd& end, const ChildLimits& limits) {
  switch (end.kind) {
    case ChildEnd::Kind::kExited:
      return fmt::format("it ended with status {}", end.number);
    case ChildEnd::Kind::kTooLong:
      return fmt::format("it made no progress for {} s and was stopped", limits.seconds);
    case ChildEnd::Kind::kOutOfMemory:
      return fmt::format("it needs more than {:.3g} GB of memory", double(limits.memory) * 1e-9);
    case ChildEnd::Kind::kNotStarted:
      return fmt::format("its process could not be started: {}", std::strerror(end.number));
    case ChildEnd::Kind::kCrashed:
      break;
  }
  if (end.number == SIGKILL) return "it was killed, perhaps because the machine's memory ran out";
  if (end.number == SIGXCPU)
    return fmt::format("it exceeded {} s of processor time and was stopped", limits.processor_seconds);
  return fmt::format("it crashed ({})", strsignal(end.number));
}

Child start_program(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                    const std::string& log, const ChildLimits& limits, int shared) {
  std::vector<char*> pointers;
  for (const std::string& argument : arguments) pointers.push_back(const_cast<char*>(argument.c_str()));
  pointers.push_back(nullptr);
  int ends[2];  // closed by a successful exec, else it carries errno
  if (pipe2(ends, O_CLOEXEC) != 0) return {-1, errno};
  const SignalsBlocked blocked;
  Child child;
  child.id = start({pointers.data(), folder.c_str(), log.c_str(), limits, shared, ends[1], getpid()});
  if (child.id < 0) child.error = errno;
  close(ends[1]);
  if (child.id > 0 && read(ends[0], &child.error, sizeof child.error) == sizeof child.error) {
    waitpid(child.id, nullptr, 0);
    child.id = -1;
  }
  close(ends[0]);
  return child;
}

std::vector<ChildEnd> wait_for(std::span<const Child> children, const ChildLimits& limits,
                               const std::function<double()>& how_far) {
  using Clock = std::chrono::steady_clock;
  std::vector<ChildEnd> ends(children.size());
  std::vector<std::size_t> running;
  for (std::size_t c = 0; c < children.size(); c++)
    if (children[c].id > 0)
      running.push_back(c);
    else
      ends[c] = {ChildEnd::Kind::kNotStarted, children[c].error};
  Clock::time_point last = Clock::now();
  double farthest = how_far ? how_far() : 0;
  while (!running.empty()) {
    std::erase_if(running, [&](std::size_t c) { return collect(children[c], ends[c], WNOHANG); });
    if (running.empty()) break;
    const double now = how_far ? how_far() : 0;
    if (now > farthest) farthest = now, last = Clock::now();
    if (std::chrono::duration<double>(Clock::now() - last).count() > limits.seconds) {
      for (const std::size_t c : running) stop(children[c], ends[c]);
      break;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return ends;
}

}  // namespace turgor::io
