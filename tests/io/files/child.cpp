#include "turgor/io/files/child.hpp"

#include <atomic>
#include <chrono>
#include <csignal>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/folders.hpp"

namespace turgor::io {
namespace {

using Kind = ChildEnd::Kind;

/// Result of a program that runs the script.
ChildEnd end_of_script(const std::string& script, const ChildLimits& limits = {}) {
  const Child child = start_program({"sh", "-c", script}, test::fresh_folder(), "log", limits);
  return wait_for({&child, 1}, limits)[0];
}

// A program that returns reports its exit status.
TEST(Child, ReportsExitStatus) {
  EXPECT_TRUE(end_of_script("exit 0"));
  const ChildEnd end = end_of_script("exit 7");
  EXPECT_EQ(end.kind, Kind::kExited);
  EXPECT_EQ(end.number, 7);
  EXPECT_EQ(describe(end, {}), "it ended with status 7");
}

// A program without progress is stopped after the time limit, with the programs that it started.
TEST(Child, HangingWorkIsStopped) {
  const ChildLimits limits{.seconds = 0.3};
  const auto begin = std::chrono::steady_clock::now();
  const ChildEnd end = end_of_script("sleep 100 & sleep 100", limits);
  EXPECT_EQ(end.kind, Kind::kTooLong);
  EXPECT_EQ(describe(end, limits), "it made no progress for 0.3 s and was stopped");
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
}

// A program that makes progress is not stopped.
TEST(Child, ProgressingWorkIsNotStopped) {
  const ChildLimits limits{.seconds = 0.3};
  const Child child = start_program({"sleep", "0.9"}, test::fresh_folder(), "log", limits);
  double steps = 0;
  EXPECT_TRUE(wait_for({&child, 1}, limits, [&] { return steps++; })[0]);
}

// A crash is reported with its signal.
TEST(Child, ReportsCrash) {
  const ChildEnd end = end_of_script("kill -SEGV $$");
  EXPECT_EQ(end.kind, Kind::kCrashed);
  EXPECT_EQ(describe(end, {}), "it crashed (Segmentation fault)");
  EXPECT_EQ(describe(end_of_script("kill -KILL $$"), {}),
            "it was killed, perhaps because the machine's memory ran out");
}

// A program has the memory limit that it is given.
TEST(Child, MemoryIsLimited) {
  const ChildLimits limits{.memory = 256ull << 20};
  EXPECT_TRUE(end_of_script("test $(ulimit -v) = 262144", limits));
  EXPECT_EQ(describe({Kind::kOutOfMemory, 0}, limits), "it needs more than 0.268 GB of memory");
}

// A busy loop is stopped by the limit of processor time.
TEST(Child, ProcessorTimeIsLimited) {
  const ChildLimits limits{.seconds = 60, .processor_seconds = 1};
  EXPECT_EQ(describe(end_of_script("while :; do :; done", limits), limits),
            "it exceeded 1 s of processor time and was stopped");
}

// A program inherits no signal handlers, masks, files, standard input or core dumps.
TEST(Child, InheritsNoProcessState) {
  sigset_t masked, before;
  sigemptyset(&masked);
  sigaddset(&masked, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &masked, &before);
  const auto handler = std::signal(SIGUSR1, SIG_IGN);
  const int file = open("/dev/null", O_RDONLY);
  const int high = fcntl(file, F_DUPFD, 77);
  EXPECT_TRUE(end_of_script("test ! -e /proc/self/fd/77 && test -z \"$(cat)\" && test \"$(ulimit -c)\" = 0"));
  EXPECT_TRUE(end_of_script("grep -q '^SigBlk:.0*$' /proc/self/status"));
  const auto ended_by = [](const ChildEnd& end) { return end.kind == Kind::kCrashed ? end.number : 0; };
  EXPECT_EQ(ended_by(end_of_script("kill -USR1 $$")), SIGUSR1) << "it was ignored here";
  close(high), close(file);
  std::signal(SIGUSR1, handler);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

// A shared file arrives under its number, whatever number it has here.
TEST(Child, SharedFileArrives) {
  const std::filesystem::path folder = test::fresh_folder();
  test::write(folder / "text", "shared");
  const int file = open((folder / "text").c_str(), O_RDONLY | O_CLOEXEC);
  for (const int number : {file, fcntl(file, F_DUPFD_CLOEXEC, 50)}) {
    lseek(number, 0, SEEK_SET);
    const Child child =
        start_program({"sh", "-c", "test \"$(cat <&3)\" = shared"}, folder, "log", {}, number);
    EXPECT_TRUE(wait_for({&child, 1}, {})[0]) << number;
    close(number);
  }
}

// A program ends when its parent ends.
TEST(Child, DiesWithItsParent) {
  const std::filesystem::path file = test::fresh_folder() / "id";
  const pid_t parent = fork();
  if (parent == 0) {
    const Child child = start_program({"sleep", "100"}, file.parent_path(), "log", {});
    std::ofstream(file) << child.id << std::flush;
    _exit(0);
  }
  ASSERT_EQ(waitpid(parent, nullptr, 0), parent);
  const std::string stat = "/proc/" + test::bytes_of(file) + "/stat";
  const auto runs = [&] {  // a dead one that is not yet reaped does not
    const std::string state = test::bytes_of(stat);
    return !state.empty() && state.find(") Z") == std::string::npos;
  };
  for (int i = 0; i < 200 && runs(); i++) usleep(10000);
  EXPECT_FALSE(runs()) << test::bytes_of(stat);
}

// A missing program is reported with the reason.
TEST(Child, MissingProgramIsReported) {
  const Child child = start_program({"no-such-program-anywhere"}, test::fresh_folder(), "log", {});
  const ChildEnd end = wait_for({&child, 1}, {})[0];
  EXPECT_EQ(end.kind, Kind::kNotStarted);
  EXPECT_EQ(describe(end, {}), "its process could not be started: No such file or directory");
}

// Programs start while other threads allocate, lock and start programs, too.
TEST(Child, ThreadsStartPrograms) {
  const std::filesystem::path folder = test::fresh_folder();
  std::vector<std::thread> threads;
  std::atomic<int> sound{0};
  for (int t = 0; t < 4; t++)
    threads.emplace_back([&] {
      for (int n = 0; n < 20; n++) {
        const Child child = start_program({"true"}, folder, "/dev/null", {});
        sound += bool(wait_for({&child, 1}, {})[0]);
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(sound, 80);
}

}  // namespace
}  // namespace turgor::io
