#include "turgor/core/exec.hpp"

#include <atomic>
#include <vector>

#include <gtest/gtest.h>

namespace turgor {
namespace {

// parallel_for visits every index exactly once on 1, 2 and 8 threads.
TEST(Exec, ParallelFor_VisitsEveryIndexOnce) {
  for (const int threads : {1, 2, 8})
    for (const std::size_t count : {0, 1, 7, 1000}) {
      std::vector<std::atomic<int>> visits(count);
      parallel_for(Exec(threads), count, [&](std::size_t i) { visits[i]++; });
      for (const auto& visit : visits) EXPECT_EQ(visit, 1);
    }
}

// A range that is no longer than the grain is run in one call.
TEST(Exec, RunRanges_RespectsGrain) {
  std::atomic<int> calls{0};
  Exec(4).run_ranges(100, 100, [&](std::size_t begin, std::size_t end) {
    EXPECT_EQ(end - begin, 100u);
    calls++;
  });
  EXPECT_EQ(calls, 1);
}

// Loops flush denormals to zero on every thread; code outside of loops does not.
TEST(Exec, ParallelFor_FlushesDenormals) {
  volatile float tiny = 1e-39f;
  for (const int threads : {1, 2, 8}) {
    std::atomic<int> nonzero{0};
    parallel_for(Exec(threads), 1000, [&](std::size_t) { nonzero += tiny * 0.5f != 0; });
    EXPECT_EQ(nonzero, 0) << threads << " threads";
  }
  EXPECT_NE(tiny * 0.5f, 0);
}

// Zero threads selects one thread per core.
TEST(Exec, ZeroThreadsMeansOnePerCore) { EXPECT_GE(Exec(0).threads(), 1); }

}  // namespace
}  // namespace turgor
