// Loops on a GPU: the third kind of run (run.hpp). Only .cu files include it.
#pragma once

#include <cstring>
#include <memory>
#include <type_traits>
#include <vector>

#include <cuda_runtime.h>

#include "turgor/core/gpu.hpp"
#include "turgor/core/run.hpp"

namespace turgor {

template <class Kernel>
__global__ void call_kernel(std::size_t count, const Kernel kernel) {
  const std::size_t n = std::size_t(blockIdx.x) * blockDim.x + threadIdx.x;
  if (n < count) kernel(n);
}
/// Address by which the CUDA runtime identifies the kernel.
template <class Kernel>
const void* function_of() {
#ifdef __CUDACC__
  return reinterpret_cast<const void*>(&call_kernel<Kernel>);
#else  // C++ with the CUDA runtime that tests simulate
  return &pretended_kernel<Kernel, call_kernel<Kernel>>;
#endif
}
inline void check_cuda(cudaError_t error) { TURGOR_ASSERT(error == cudaSuccess, cudaGetErrorString(error)); }

/// Kernels recorded to run one after the other, as a CUDA graph that the GPU replays with a single launch.
/// The graph is rebuilt when a kernel, its count or one of its arguments changes, for example after a cut.
/// Arguments are compared byte by byte, so differing padding may cause an unnecessary rebuild.
class LoopGraph {
 public:
  LoopGraph() = default;
  LoopGraph(const LoopGraph&) = delete;
  LoopGraph& operator=(const LoopGraph&) = delete;
  ~LoopGraph() {
    if (graph_) cudaGraphExecDestroy(graph_);
  }

  void begin() { is_open = true, next_ = 0; }
  void add(const void* function, dim3 blocks, dim3 threads, std::size_t count, const void* kernel,
           std::size_t bytes) {
    if (next_ == loops_.size()) loops_.emplace_back();
    Loop& loop = loops_[next_++];
    const bool is_same = loop.function == function && loop.count == count && loop.kernel.size() == bytes &&
                         std::memcmp(loop.kernel.data(), kernel, bytes) == 0;
    if (is_same) return;
    const auto* first = static_cast<const std::byte*>(kernel);
    loop = {function, blocks, threads, count, {first, first + bytes}};
    has_changed_ = true;
  }
  void end_and_launch() {
    is_open = false;
    if (next_ != loops_.size()) loops_.resize(next_), has_changed_ = true;
    if (loops_.empty()) return;
    if (has_changed_) renew();
    has_changed_ = false;
    check_cuda(cudaGraphLaunch(graph_, nullptr));
  }

  bool is_open = false;

 private:
  struct Loop {
    const void* function = nullptr;
    dim3 blocks, threads;
    std::size_t count = 0;
    std::vector<std::byte> kernel;
  };

  /// Updates the arguments of a graph with the same kernels, or instantiates a new graph.
  void renew() {
    cudaGraph_t chain = nullptr;
    check_cuda(cudaGraphCreate(&chain, 0));
    cudaGraphNode_t last = nullptr;
    for (Loop& loop : loops_) {
      void* arguments[] = {&loop.count, loop.kernel.data()};
      cudaKernelNodeParams node{};
      node.func = const_cast<void*>(loop.function);
      node.gridDim = loop.blocks, node.blockDim = loop.threads;
      node.kernelParams = arguments;
      const cudaGraphNode_t before = last;
      check_cuda(cudaGraphAddKernelNode(&last, chain, before ? &before : nullptr, before ? 1 : 0, &node));
    }
    cudaGraphExecUpdateResultInfo updated{};
    if (!graph_ || cudaGraphExecUpdate(graph_, chain, &updated) != cudaSuccess) {
      cudaGetLastError();  // another topology is not an error
      if (graph_) cudaGraphExecDestroy(graph_);
      check_cuda(cudaGraphInstantiate(&graph_, chain, 0));
    }
    check_cuda(cudaGraphDestroy(chain));
  }

  std::vector<Loop> loops_;
  std::size_t next_ = 0;
  bool has_changed_ = false;
  cudaGraphExec_t graph_ = nullptr;
};

/// One thread per index. Kernels run in the order of their launches.
struct GpuRun {
  bool one_by_one = false;  // launch kernels one by one, without graphs
  std::unique_ptr<LoopGraph> together = std::make_unique<LoopGraph>();

  template <class Kernel>
  void operator()(std::size_t count, const Kernel& kernel, std::size_t = 1) const {
    static_assert(sizeof(Kernel) <= 4000, "kernels are passed as launch arguments, limited to 4096 bytes");
    static_assert(std::is_trivially_copyable_v<Kernel>, "kernels are copied byte by byte");
    constexpr unsigned kThreads = 128;
    const auto blocks = unsigned((count + kThreads - 1) / kThreads);
    if (count == 0) return;
    if (together->is_open)
      return together->add(function_of<Kernel>(), blocks, kThreads, count, &kernel, sizeof(Kernel));
    void* arguments[] = {&count, const_cast<Kernel*>(&kernel)};
    check_cuda(cudaLaunchKernel(function_of<Kernel>(), blocks, kThreads, arguments, 0, nullptr));
  }
};
/// Records the loops of run_together (run.hpp) as a graph.
template <class Loops>
void run_together(const GpuRun& run, const Loops& loops) {
  if (run.one_by_one) return loops();
  run.together->begin();
  loops();
  run.together->end_and_launch();
}

/// GPU backend: the arrays and the run that device code is templated on.
struct GpuBackend {
  template <class T>
  using Array = GpuArray<T>;
  using Run = GpuRun;
};

}  // namespace turgor
