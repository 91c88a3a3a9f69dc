#include "turgor/core/start_thread.hpp"

#include <atomic>
#include <fstream>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include "turgor/core/exec.hpp"

namespace turgor {
namespace {

/// Leaves this much address space to the process.
void leave_memory(rlim_t bytes) {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlim_t most = rlim_t(pages) * rlim_t(sysconf(_SC_PAGESIZE)) + bytes;
  const rlimit limit{most, most};
  setrlimit(RLIMIT_AS, &limit);
}

constexpr rlim_t kFewStacks = rlim_t(40) << 20;  // of 8 MB

/// A sum of 100 000 numbers, 0 if a number was left out.
int check_loop(const Exec& exec) {
  std::atomic<long> sum{0};
  parallel_for(exec, 100'000, [&sum](std::size_t n) { sum += long(n); });
  return sum == 4'999'950'000 ? 0 : 1;
}

// A loop runs with fewer threads where the system refuses some.
TEST(StartThreadDeathTest, LoopRunsWithFewerThreads) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        leave_memory(kFewStacks);
        const Exec exec(64);
        _exit(exec.threads() < 64 && exec.threads() > 0 ? check_loop(exec) : 2);
      },
      testing::ExitedWithCode(0), "");
}

#if !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)  // sanitizers need memory for a thread of their own
// A thread that cannot start is an error with its purpose and the reason.
TEST(StartThreadDeathTest, RefusedThreadIsAnError) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        leave_memory(0);
        const Result<std::thread> thread = start_thread("a test", [] {});
        if (!thread) std::fprintf(stderr, "%s\n", thread.error().message.c_str());
        _exit(thread ? 1 : 0);
      },
      testing::ExitedWithCode(0), "cannot start the thread of a test: Resource temporarily unavailable");
}
#endif

// Without limits every wanted thread starts.
TEST(StartThread, AllThreadsStart) {
  EXPECT_EQ(Exec(12).threads(), 12);
  EXPECT_EQ(startable_threads(1), 1);
}

// A thread has the name of its purpose, without the article.
TEST(StartThread, NamesThread) {
  std::atomic<bool> ends = false;
  Result<std::thread> thread = start_thread("the haptic loop", [&ends] { ends.wait(false); });
  ASSERT_TRUE(thread);
  char name[16] = {};
  EXPECT_EQ(pthread_getname_np(thread->native_handle(), name, sizeof name), 0);
  EXPECT_STREQ(name, "haptic loop");
  ends = true, ends.notify_all();
  thread->join();
}

}  // namespace
}  // namespace turgor
