// Measured limits of a GPU (roofline): memory bandwidth and arithmetic rate. Benches report kernels relative
// to them.
#pragma once

#include "turgor/core/gpu.hpp"

namespace turgor {

struct GpuLimits {
  double copy_bandwidth = 0;   // read and written [B/s]
  double arithmetic_rate = 0;  // single precision; a multiply-add counts as two [1/s]
};
/// Measures with kernels of gpu_run.cuh. Error: less than 512 MB are free.
Result<GpuLimits> measure_limits(const Gpu& gpu);

}  // namespace turgor
