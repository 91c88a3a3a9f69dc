// Descent's sweeps on a GPU: compiled, so that they stay fit for it, and called by nobody yet (docs/gpu.md).
#include "turgor/core/gpu_run.cuh"
#include "turgor/models/lattice/descent_loops.hpp"

namespace turgor::lattice {

template void sweep_descent_with(const GpuRun& run, const DescentView& view, Order order);

}  // namespace turgor::lattice
