// What the machine can do, measured beside what we do with it.
#pragma once

#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/timing.hpp"

namespace turgor {

/// Of `runs` runs, wall time [ms].
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

/// Bytes read and written a second by copying 256 MiB.
double copy_bandwidth(const Exec& exec);
/// Floating-point operations a second, single precision, of dense products, one a thread.
double arithmetic_rate(const Exec& exec);

}  // namespace turgor
