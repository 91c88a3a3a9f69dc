#include "turgor/core/gpu_limits.hpp"
#include "turgor/core/gpu_run.cuh"
#include "turgor/core/timing.hpp"

namespace turgor {

namespace {

struct alignas(16) Four {
  float a, b, c, d;
};
struct CopyFour {
  const Four* from;
  Four* to;
  __device__ void operator()(std::size_t n) const { to[n] = from[n]; }
};
/// Independent chains per thread hide the latency of each multiply-add.
struct MultiplyAdd {
  static constexpr int kChains = 8, kTurns = 1024;
  float* to;
  __device__ void operator()(std::size_t n) const {
    float x[kChains];
    for (int c = 0; c < kChains; c++) x[c] = float(n + c);
    for (int turn = 0; turn < kTurns; turn++)
#pragma unroll
      for (int c = 0; c < kChains; c++) x[c] = fmaf(x[c], 0.75f, 0.5f);
    float sum = 0;
    for (int c = 0; c < kChains; c++) sum += x[c];
    to[n] = sum;
  }
};

/// Median of several runs [s].
template <class Kernel>
double seconds_of(std::size_t count, const Kernel& kernel) {
  const GpuRun run;
  std::vector<double> times;
  for (int turn = 0; turn < 9; turn++) {
    const Timer timer;
    run(count, kernel);
    cudaDeviceSynchronize();
    times.push_back(timer.seconds());
  }
  return median(times);
}

}  // namespace

Result<GpuLimits> measure_limits(const Gpu& gpu) {
  constexpr std::size_t kFours = std::size_t(16) << 20, kThreads = std::size_t(1) << 22;
  const GpuArray<Four> from(kFours), to(kFours);
  if (!from.is_allocated() || !to.is_allocated())
    return Error{gpu.name + " needs 512 MB of free memory to measure its limits"};
  const double copy = seconds_of(kFours, CopyFour{from.data(), to.data()});
  const double arithmetic = seconds_of(kThreads, MultiplyAdd{reinterpret_cast<float*>(to.data())});
  constexpr double kOperations = 2.0 * MultiplyAdd::kChains * MultiplyAdd::kTurns * double(kThreads);
  return GpuLimits{.copy_bandwidth = 2 * sizeof(Four) * double(kFours) / copy,
                   .arithmetic_rate = kOperations / arithmetic};
}

}  // namespace turgor
