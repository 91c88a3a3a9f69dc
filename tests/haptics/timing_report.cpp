#include "turgor/haptics/timing_report.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "turgor/core/timing.hpp"

namespace turgor::haptics {

// Percentiles of the histogram match those of the sorted samples to 0.6 percent.
TEST(TimingReport, PercentilesMatchSortedSamples) {
  LogHistogram histogram;
  std::vector<double> samples;
  unsigned long state = 12345;
  for (int i = 0; i < 200000; i++) {
    state = state * 6364136223846793005ul + 1442695040888963407ul;
    samples.push_back(1e-6 * std::exp(8.0 * double(state >> 40) / double(1ul << 24)));
    histogram.add(samples.back());
  }
  const Spread spread = histogram.spread();
  EXPECT_NEAR(spread.p50 / percentile(samples, 0.5), 1, 0.006);
  EXPECT_NEAR(spread.p99 / percentile(samples, 0.99), 1, 0.006);
  EXPECT_NEAR(spread.p999 / percentile(samples, 0.999), 1, 0.006);
  EXPECT_EQ(spread.largest, percentile(samples, 1));
  EXPECT_EQ(histogram.count(), 200000u);
}

// Times outside of the range of the histogram are counted in its end buckets.
TEST(TimingReport, OutOfRangeTimesAreClamped) {
  LogHistogram histogram;
  EXPECT_EQ(histogram.spread().p99, 0);  // no samples yet
  for (const double seconds : {0.0, 0.0, 1e-12, 1e6}) histogram.add(seconds);
  EXPECT_EQ(histogram.spread().p50, 0);
  EXPECT_EQ(histogram.spread().largest, 1e6);
}

// The rate is the number of ticks over their total time.
TEST(TimingReport, RateIsTicksOverTime) {
  TimingRecord record;
  for (int i = 0; i < 1000; i++) record.period.add(i % 2 ? 1.5e-3 : 0.5e-3), record.compute.add(1e-5);
  const TimingReport report = timing_report(record);
  EXPECT_NEAR(report.rate, 1000, 1e-6);
  EXPECT_NEAR(report.seconds, 1, 1e-9);
  EXPECT_EQ(report.ticks, 1000u);
}

}  // namespace turgor::haptics
