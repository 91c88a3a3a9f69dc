// Wall-clock timing and the percentiles that reports show.
#pragma once

#include <chrono>
#include <vector>

namespace turgor {

class Timer {
 public:
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

/// Percentile by nearest rank: the sample of rank round(fraction · (n - 1)); 0 without samples.
double percentile(std::vector<double> samples, double fraction);

inline double median(std::vector<double> samples) { return percentile(std::move(samples), 0.5); }

}  // namespace turgor
