// What a GPU can do at most, measured: beside what it does, in benches.
#pragma once

#include "turgor/core/gpu.hpp"

namespace turgor {

struct GpuLimits {
  double copy_bandwidth = 0;   // read and written [B/s]
  double arithmetic_rate = 0;  // single precision, a multiplication with an addition as two [1/s]
};
/// By loops like any other (gpu_run.cuh). Error: there are not 512 MB for it.
Result<GpuLimits> measure_limits(const Gpu& gpu);

}  // namespace turgor
