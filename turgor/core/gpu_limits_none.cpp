// In place of gpu_limits.cu where there is no nvcc.
#include "turgor/core/gpu_limits.hpp"

namespace turgor {

Result<GpuLimits> measure_limits(const Gpu&) { return open_gpu().error(); }

}  // namespace turgor
