#include "turgor/core/timing.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

// Percentiles are ranks of the sorted samples; the median of no samples is zero.
TEST(Timing, PercentilesAreRanksOfSortedSamples) {
  const std::vector<double> samples{5, 1, 4, 2, 3};
  EXPECT_EQ(percentile(samples, 0), 1);
  EXPECT_EQ(percentile(samples, 0.5), 3);
  EXPECT_EQ(percentile(samples, 1), 5);
  EXPECT_EQ(median({}), 0);
}

}  // namespace
}  // namespace turgor
