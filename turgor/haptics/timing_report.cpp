#include "turgor/haptics/timing_report.hpp"

#include <algorithm>
#include <cmath>

namespace turgor::haptics {

void LogHistogram::add(double seconds) {
  const double bucket = seconds > kLowest ? kPerDecade * std::log10(seconds / kLowest) : 0;
  buckets_[std::size_t(std::clamp(bucket, 0.0, double(kBuckets - 1)))]++;
  count_++;
  sum_ += seconds;
  largest_ = std::max(largest_, seconds);
}

/// The middle of the bucket in which it lies.
double LogHistogram::percentile(double fraction) const {
  const double rank = fraction * double(count_);
  std::uint64_t below = 0;
  for (int b = 0; b < kBuckets; b++) {
    below += buckets_[std::size_t(b)];
    if (below > 0 && double(below) >= rank)
      return std::min(largest_, b == 0 ? 0 : kLowest * std::pow(10, (b + 0.5) / kPerDecade));
  }
  return largest_;
}

Spread LogHistogram::spread() const {
  if (count_ == 0) return {};
  return {percentile(0.5), percentile(0.99), percentile(0.999), largest_};
}

TimingReport timing_report(const TimingRecord& record) {
  const double seconds = record.period.sum();
  return {.ticks = record.compute.count(),
          .seconds = seconds,
          .rate = seconds > 0 ? double(record.period.count()) / seconds : 0,
          .period = record.period.spread(),
          .compute = record.compute.spread(),
          .latency = record.latency.spread(),
          .age = record.age.spread(),
          .missed = record.missed,
          .force_jump = record.force_jump,
          .torque_jump = record.torque_jump,
          .asked_jump = record.asked_jump};
}

}  // namespace turgor::haptics
