// Timing of a haptic loop, and the actions of its safety chain. Times are collected in histograms of fixed
// size, so that memory does not grow and a tick allocates nothing.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "turgor/haptics/safety.hpp"

namespace turgor::haptics {

/// Percentiles of a time [s].
struct Spread {
  double p50 = 0, p99 = 0, p999 = 0, largest = 0;
};

/// Histogram with buckets that grow by 1 % from 10 ns to 100 s. The first and last bucket also take shorter
/// and longer times. Percentiles are exact to 0.5 %, the largest value is exact.
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

/// Counters of a running loop.
struct TimingRecord {
  LogHistogram period, jitter, compute, latency, age;
  std::uint64_t missed = 0;
  double force_jump = 0, torque_jump = 0, model_force_jump = 0;  // as in the report
};

/// Summary of the counters.
struct TimingReport {
  std::uint64_t ticks = 0;
  double seconds = 0;
  double target_rate = 0, rate = 0;  // [Hz]
  Spread period;                     // from the start of a tick to that of the next
  Spread jitter;                     // deviation of the period from the target
  Spread compute;                    // work of loop and model, without waiting for the device
  Spread latency;                    // from the reading of a pose to its force
  Spread age;                        // of the data that the model used
  std::uint64_t missed = 0;          // ticks whose deadline had passed before they could start
  double force_jump = 0;             // largest change of the rendered force from tick to tick [N]
  double torque_jump = 0;            // [N·m]
  double model_force_jump = 0;       // largest change of the model's force [N]
  double lowest_energy = 0;          // smallest W of any device; below 0 the model created energy [J]
  SafetyCounts safety;               // of all devices
};

/// Summary of the recorded counts and times. The caller fills in `target_rate` and the device's fields.
TimingReport timing_report(const TimingRecord& record);

}  // namespace turgor::haptics
