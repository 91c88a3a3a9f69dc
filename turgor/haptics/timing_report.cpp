#include "turgor/haptics/timing_report.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"

namespace turgor::haptics {

void LogHistogram::add(double seconds) {
  TURGOR_CHECK(!std::isnan(seconds), "a recorded time is a number");
  const double bucket = seconds > kLowest ? kPerDecade * std::log10(seconds / kLowest) : 0;
  buckets_[std::size_t(std::clamp(bucket, 0.0, double(kBuckets - 1)))]++;
  count_++;
  sum_ += seconds;
  largest_ = std::max(largest_, seconds);
}

/// Value that represents the samples of a bucket [s].
double LogHistogram::middle(int bucket) const {
  TURGOR_CHECK(bucket >= 0 && bucket < kBuckets, "a bucket belongs to the histogram");
  return std::min(largest_, bucket == 0 ? 0 : kLowest * std::pow(10, (bucket + 0.5) / kPerDecade));
}

Spread LogHistogram::spread() const {
  if (count_ == 0) return {};
  constexpr double kFractions[] = {0.5, 0.99, 0.999};
  double found[3] = {largest_, largest_, largest_};
  std::uint64_t below = 0;
  int next = 0;
  for (int b = 0; b < kBuckets && next < 3; b++) {
    below += buckets_[std::size_t(b)];
    while (next < 3 && below > 0 && double(below) >= kFractions[next] * double(count_))
      found[next++] = middle(b);
  }
  TURGOR_CHECK(next == 3, "every percentile lies in a bucket");
  return {found[0], found[1], found[2], largest_};
}

TimingReport timing_report(const TimingRecord& record) {
  // total time, for the mean rate
  const double seconds = record.period.sum();
  return {.ticks = record.compute.count(),
          .seconds = seconds,
          .rate = seconds > 0 ? double(record.period.count()) / seconds : 0,
          .period = record.period.spread(),
          .jitter = record.jitter.spread(),
          .compute = record.compute.spread(),
          .latency = record.latency.spread(),
          .age = record.age.spread(),
          .missed = record.missed,
          .force_jump = record.force_jump,
          .torque_jump = record.torque_jump,
          .model_force_jump = record.model_force_jump};
}

}  // namespace turgor::haptics
