#include "turgor/io/files/child.hpp"

#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <new>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include "tests/folders.hpp"

namespace turgor::io {
namespace {

using Kind = ChildEnd::Kind;

ChildEnd end_of(const std::function<int()>& work, const ChildLimits& limits = {}) {
  const Child child = start_child(work, limits);
  return wait_for({&child, 1}, limits)[0];
}

/// Result of a program that runs the script.
ChildEnd end_of_script(const std::string& script, const ChildLimits& limits = {}) {
  const Child child = start_program({"sh", "-c", script}, test::fresh_folder(), "log", limits);
  return wait_for({&child, 1}, limits)[0];
}

// A child process that returns reports its exit status.
TEST(Child, ReportsExitStatus) {
  EXPECT_TRUE(end_of([] { return 0; }));
  const ChildEnd end = end_of([] { return 7; });
  EXPECT_EQ(end.kind, Kind::kExited);
  EXPECT_EQ(end.number, 7);
  EXPECT_EQ(describe(end, {}), "it ended with status 7");
  EXPECT_FALSE(end_of([]() -> int { throw 3; }));
}

// A child process without progress is stopped after the time limit.
TEST(Child, HangingWorkIsStopped) {
  const ChildLimits limits{.seconds = 0.2};
  const ChildEnd end = end_of(
      []() -> int {
        for (;;) pause();
      },
      limits);
  EXPECT_EQ(end.kind, Kind::kTooLong);
  EXPECT_EQ(describe(end, limits), "it made no progress for 0.2 s and was stopped");
}

// A child process that makes progress is not stopped.
TEST(Child, ProgressingWorkIsNotStopped) {
  const ChildLimits limits{.seconds = 0.3};
  const Child child = start_child([] { return usleep(900000), 0; }, limits);
  double steps = 0;
  EXPECT_TRUE(wait_for({&child, 1}, limits, [&] { return steps++; })[0]);
}

// A crash is reported with its signal.
TEST(Child, ReportsCrash) {
  const ChildEnd end = end_of([]() -> int { return raise(SIGSEGV); });
  EXPECT_EQ(end.kind, Kind::kCrashed);
  EXPECT_EQ(describe(end, {}), "it crashed (Segmentation fault)");
  const ChildEnd killed = end_of([]() -> int { return raise(SIGKILL); });
  EXPECT_EQ(describe(killed, {}), "it was killed, perhaps because the machine's memory ran out");
}

// A child process cannot allocate more than its memory limit.
TEST(Child, MemoryIsLimited) {
  const ChildLimits limits{.memory = 256ull << 20};
  const ChildEnd end = end_of(
      []() -> int {
        if (mmap(nullptr, 1ull << 30, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) != MAP_FAILED) return 0;
        throw std::bad_alloc();
      },
      limits);
  EXPECT_EQ(end.kind, Kind::kOutOfMemory);
  EXPECT_EQ(describe(end, limits), "it needs more than 0.268 GB of memory");
}

// A busy loop is stopped by the limit of processor time.
TEST(Child, ProcessorTimeIsLimited) {
  const ChildLimits limits{.seconds = 60, .processor_seconds = 1};
  const ChildEnd end = end_of(
      [] {
        for (volatile bool on = true; on;) {
        }
        return 0;
      },
      limits);
  EXPECT_EQ(describe(end, limits), "it exceeded 1 s of processor time and was stopped");
}

// A child process inherits no signal handlers, masks, files, standard input or core dumps.
TEST(Child, InheritsNoProcessState) {
  sigset_t masked, before;
  sigemptyset(&masked);
  sigaddset(&masked, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &masked, &before);
  const auto handler = std::signal(SIGUSR1, [](int) { _exit(0); });
  const int file = open("/dev/null", O_RDONLY);
  const ChildEnd end = end_of([file] {
    sigset_t mask;
    sigprocmask(SIG_SETMASK, nullptr, &mask);
    if (sigismember(&mask, SIGTERM)) return 1;
    struct sigaction action {};
    sigaction(SIGUSR1, nullptr, &action);
    if (action.sa_handler != SIG_DFL) return 2;
    if (fcntl(file, F_GETFD) != -1) return 3;
    char byte;
    if (read(STDIN_FILENO, &byte, 1) != 0) return 4;
    rlimit core{};
    getrlimit(RLIMIT_CORE, &core);
    return core.rlim_max == 0 ? 0 : 5;
  });
  EXPECT_TRUE(end) << "check " << end.number;
  close(file);
  std::signal(SIGUSR1, handler);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

// A child process ends when its parent ends.
TEST(Child, DiesWithItsParent) {
  const std::filesystem::path folder = test::fresh_folder();
  const std::string file = folder / "id";
  EXPECT_TRUE(end_of([&] {
    const Child inner = start_child(
        []() -> int {
          for (;;) pause();
        },
        {});
    std::ofstream(file) << inner.id;
    return 0;
  }));
  const pid_t inner = std::stoi(test::bytes_of(file));
  for (int i = 0; i < 200 && kill(inner, 0) == 0; i++) {
    const std::string state = test::bytes_of("/proc/" + std::to_string(inner) + "/stat");
    if (state.find(") Z") != std::string::npos) break;  // dead, but not yet reaped
    usleep(10000);
  }
  const std::string state = test::bytes_of("/proc/" + std::to_string(inner) + "/stat");
  EXPECT_TRUE(state.empty() || state.find(") Z") != std::string::npos) << state;
}

// The same limits apply to programs that are started from a file.
TEST(Child, ProgramsHaveSameLimits) {
  EXPECT_TRUE(end_of_script("exit 0"));
  EXPECT_EQ(end_of_script("exit 254").kind, Kind::kExited);
  EXPECT_EQ(end_of_script("kill -SEGV $$").kind, Kind::kCrashed);
  EXPECT_TRUE(end_of_script("test \"$(ulimit -c)\" = 0 && test -z \"$(cat)\" && test ! -e /proc/self/fd/9"));
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(end_of_script("sleep 100 & sleep 100", {.seconds = 0.3}).kind, Kind::kTooLong);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
}

// A missing program is reported with the reason.
TEST(Child, MissingProgramIsReported) {
  const Child child = start_program({"no-such-program-anywhere"}, test::fresh_folder(), "log", {});
  const ChildEnd end = wait_for({&child, 1}, {})[0];
  EXPECT_EQ(end.kind, Kind::kNotStarted);
  EXPECT_EQ(describe(end, {}), "its process could not be started: No such file or directory");
}

// A process that the system refuses to create is reported as not started.
TEST(Child, ProcessLimitIsReported) {
  if (getuid() == 0) GTEST_SKIP() << "the process limit does not apply to root";
  const ChildEnd end = end_of([] {
    const rlimit none{0, 0};
    setrlimit(RLIMIT_NPROC, &none);
    const Child child = start_child([] { return 0; }, {});
    return wait_for({&child, 1}, {})[0].kind == Kind::kNotStarted ? 0 : 1;
  });
  EXPECT_TRUE(end);
}

}  // namespace
}  // namespace turgor::io
