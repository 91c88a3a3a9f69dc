// Loops on a GPU: the third kind of run (run.hpp), for .cu files alone.
#pragma once

#include <cuda_runtime.h>

#include "turgor/core/gpu.hpp"
#include "turgor/core/run.hpp"

namespace turgor {

template <class Kernel>
__global__ void call_kernel(std::size_t count, const Kernel kernel) {
  const std::size_t n = std::size_t(blockIdx.x) * blockDim.x + threadIdx.x;
  if (n < count) kernel(n);
}

/// A thread an index. What is run next on the same stream begins when this is done.
struct GpuRun {
  cudaStream_t stream = nullptr;

  template <class Kernel>
  void operator()(std::size_t count, const Kernel& kernel, std::size_t = 1) const {
    static_assert(sizeof(Kernel) <= 4000, "kernels go over as arguments, of which there may be 4096 bytes");
    constexpr unsigned kThreads = 128;
    if (count > 0)
      call_kernel<<<unsigned((count + kThreads - 1) / kThreads), kThreads, 0, stream>>>(count, kernel);
  }
};

/// A GPU as the side that arrays and loops are on.
struct GpuSide {
  template <class T>
  using Array = GpuArray<T>;
  using Run = GpuRun;
};

}  // namespace turgor
