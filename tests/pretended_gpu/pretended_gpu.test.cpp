// That the pretended GPU finds what a real one would fall over.
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

TEST(PretendedGpu, kernels_one_by_one_and_as_a_graph_go_over_all_of_an_array) {
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

TEST(PretendedGpu, the_same_loops_are_one_graph_and_other_numbers_renew_it) {
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
  EXPECT_EQ(graphs_after(c, 3), 0) << "its arguments were renewed";
  EXPECT_EQ(graphs_after(c, 2), 1);
}

TEST(PretendedGpuDeathTest, what_a_gpu_would_fall_over_ends_the_program) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  GpuArray<int> there(1024);
  EXPECT_DEATH(there.data()[3]++, "") << "memory there, from here";
  EXPECT_DEATH(GpuRun()(1024, NextInChain{there.data()}), "") << "behind its end";
}

TEST(PretendedGpu, what_it_has_no_room_for_is_said) {
  const std::size_t free = open_gpu().value().free_bytes;
  EXPECT_TRUE(GpuArray<char>(std::size_t(1) << 20).is_allocated());
  EXPECT_FALSE(GpuArray<char>(free + 1).is_allocated());
}

}  // namespace
}  // namespace turgor
