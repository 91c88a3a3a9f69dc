// The pretended GPU detects the errors that a real one would fail on.
#include <gtest/gtest.h>

#include "turgor/core/gpu_run.cuh"

namespace turgor {
namespace {

struct Double {
  int *from, *to;
  void operator()(std::size_t n) const { to[n] = 2 * from[n]; }
};
struct NextInChain {
  int* numbers;
  void operator()(std::size_t n) const { numbers[n + 1]++; }
};

// Kernels visit every element of an array, launched one by one and as a graph.
TEST(PretendedGpu, KernelsCoverWholeArray) {
  std::vector<int> numbers(1000);
  std::iota(numbers.begin(), numbers.end(), 0);
  GpuArray<int> from(1000), to(1000);
  const GpuRun run;
  for (int turn = 0; turn < 4; turn++) {
    from.upload(numbers);
    if (turn == 0)
      run(1000, Double{from.data(), to.data()});
    else
      run_together(run, [&] {
        run(1000, Double{from.data(), to.data()});
        if (turn == 3) run(500, Double{from.data(), to.data()});
      });
    std::vector<int> found(1000);
    to.download(found);
    for (int n = 0; n < 1000; n++) ASSERT_EQ(found[std::size_t(n)], 2 * numbers[std::size_t(n)]);
    for (int& n : numbers) n += 7;
  }
}

// Equal sequences of kernels reuse one graph; another number of kernels creates a new one.
TEST(PretendedGpu, EqualLoopsReuseGraph) {
  GpuArray<int> a(100), b(100), c(100);
  a.upload(std::vector<int>(100));
  const GpuRun run;
  const auto graphs_after = [&](GpuArray<int>& to, int loops) {
    const PretendedCounts before = pretended_counts();
    run_together(run, [&] {
      for (int n = 0; n < loops; n++) run(100, Double{a.data(), to.data()});
    });
    const PretendedCounts now = pretended_counts();
    EXPECT_EQ(now.launches, before.launches + 1);
    EXPECT_EQ(now.kernels, before.kernels + loops);
    return now.graphs - before.graphs;
  };
  EXPECT_EQ(graphs_after(b, 3), 1);
  EXPECT_EQ(graphs_after(b, 3), 0);
  EXPECT_EQ(graphs_after(c, 3), 0) << "its arguments were updated";
  EXPECT_EQ(graphs_after(c, 2), 1);
}

// Host access to device memory and access beyond its end stop the program.
TEST(PretendedGpuDeathTest, InvalidAccessEndsProgram) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  GpuArray<int> array(1024);
  EXPECT_DEATH(array.data()[3]++, "") << "host access to device memory";
  EXPECT_DEATH(GpuRun()(1024, NextInChain{array.data()}), "") << "beyond the end of the array";
}

// An allocation beyond the free memory fails and is reported.
TEST(PretendedGpu, ReportsFailedAllocation) {
  const std::size_t free = open_gpu().value().free_bytes;
  EXPECT_TRUE(GpuArray<char>(std::size_t(1) << 20).is_allocated());
  EXPECT_FALSE(GpuArray<char>(free + 1).is_allocated());
}

}  // namespace
}  // namespace turgor
