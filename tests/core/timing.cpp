#include "turgor/core/timing.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

TEST(timing, percentiles_are_ranks_of_the_sorted_samples) {
  const std::vector<double> samples{5, 1, 4, 2, 3};
  EXPECT_EQ(percentile(samples, 0), 1);
  EXPECT_EQ(percentile(samples, 0.5), 3);
  EXPECT_EQ(percentile(samples, 1), 5);
  EXPECT_EQ(median({}), 0);
}

}  // namespace
}  // namespace turgor
