#include "turgor/core/exec.hpp"

#include <atomic>
#include <vector>

#include <gtest/gtest.h>

namespace turgor {
namespace {

TEST(exec, every_index_is_visited_once_on_any_number_of_threads) {
  for (const int threads : {1, 2, 8})
    for (const std::size_t count : {0, 1, 7, 1000}) {
      std::vector<std::atomic<int>> visits(count);
      parallel_for(Exec(threads), count, [&](std::size_t i) { visits[i]++; });
      for (const auto& visit : visits) EXPECT_EQ(visit, 1);
    }
}

TEST(exec, ranges_are_not_split_below_the_grain) {
  std::atomic<int> calls{0};
  Exec(4).run_ranges(100, 100, [&](std::size_t begin, std::size_t end) {
    EXPECT_EQ(end - begin, 100u);
    calls++;
  });
  EXPECT_EQ(calls, 1);
}

TEST(exec, denormals_are_zero_inside_loops_on_every_thread_and_only_there) {
  volatile float tiny = 1e-39f;
  for (const int threads : {1, 2, 8}) {
    std::atomic<int> nonzero{0};
    parallel_for(Exec(threads), 1000, [&](std::size_t) { nonzero += tiny * 0.5f != 0; });
    EXPECT_EQ(nonzero, 0) << threads << " threads";
  }
  EXPECT_NE(tiny * 0.5f, 0);
}

TEST(exec, zero_threads_means_one_per_core) { EXPECT_GE(Exec(0).threads(), 1); }

}  // namespace
}  // namespace turgor
