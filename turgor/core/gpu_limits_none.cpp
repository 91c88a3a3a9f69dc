// Replaces gpu_limits.cu in builds without nvcc.
#include "turgor/core/gpu_limits.hpp"

namespace turgor {

Result<GpuLimits> measure_limits(const Gpu&) { return open_gpu().error(); }

}  // namespace turgor
