// Limits of the machine, measured beside the benchmarks: copy bandwidth and arithmetic rate.
#pragma once

#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/timing.hpp"

namespace turgor {

/// Median wall time of `runs` runs [ms].
template <class Work>
double median_ms(int runs, const Work& work) {
  std::vector<double> times;
  for (int n = 0; n < runs; n++) {
    const Timer timer;
    work();
    times.push_back(timer.seconds() * 1e3);
  }
  return median(times);
}

/// Bytes read and written per second by copies of 256 MiB.
double copy_bandwidth(const Exec& exec);
/// Floating-point operations per second in single precision, of dense products, one per thread.
double arithmetic_rate(const Exec& exec);

}  // namespace turgor
