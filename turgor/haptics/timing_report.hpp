// How well a loop kept its time, and what it did to what was felt. Times are counted in histograms of fixed
// size while it runs, so that a day costs what a second does and a tick allocates nothing.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "turgor/haptics/safety.hpp"

namespace turgor::haptics {

/// Of a time [s].
struct Spread {
  double p50 = 0, p99 = 0, p999 = 0, largest = 0;
};

/// Buckets that grow by 1 % from 10 ns to 100 s; what is shorter is in the first one, what is longer in the
/// last. Percentiles are right to 0.5 %, the largest is exact.
class LogHistogram {
 public:
  void add(double seconds);
  std::uint64_t count() const { return count_; }
  double sum() const { return sum_; }  // [s]
  Spread spread() const;

 private:
  static constexpr double kLowest = 1e-8;
  static constexpr int kPerDecade = 240, kBuckets = 10 * kPerDecade;
  double middle(int bucket) const;
  std::array<std::uint64_t, kBuckets> buckets_{};
  std::uint64_t count_ = 0;
  double sum_ = 0, largest_ = 0;
};

/// What is counted while a loop runs.
struct TimingRecord {
  LogHistogram period, jitter, compute, latency, age;
  std::uint64_t missed = 0;
  double force_jump = 0, torque_jump = 0, asked_jump = 0;  // as in the report
};

/// What is told of it.
struct TimingReport {
  std::uint64_t ticks = 0;
  double seconds = 0;
  double rate_asked = 0, rate = 0;  // [Hz]
  Spread period;                    // from the begin of a tick to the next one's
  Spread jitter;                    // how far that was from the period that was asked for
  Spread compute;                   // the loop's and the model's work, without waiting for the device
  Spread latency;                   // from the pose that was read to the force that answers it
  Spread age;                       // of what the model answered from
  std::uint64_t missed = 0;         // ticks whose time had passed before they could begin
  double force_jump = 0;            // largest from tick to tick of what was felt [N]
  double torque_jump = 0;           // [N·m]
  double asked_jump = 0;            // of what the model asked for [N]
  double lowest_energy = 0;         // smallest W of any device; below 0 the model gave energy away [J]
  SafetyCounts safety;              // of all devices
};

/// Adds counts and times up; `rate_asked` and what devices know is the caller's to fill.
TimingReport timing_report(const TimingRecord& record);

}  // namespace turgor::haptics
