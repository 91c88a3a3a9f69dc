// Replacement of CUDA's header for tests. It declares what turgor's .cu files use, so that they compile as
// C++ and run without a GPU (pretended_gpu.cpp). A kernel runs on several host threads. Only kernels and
// copies can access device memory: host code that reads it, or any access beyond its end, stops the program
// at once. Kernels that access host memory are not detected.
#pragma once

#include <cmath>
#include <cstddef>

#define __global__
#define __device__

struct dim3 {
  unsigned x = 1, y = 1, z = 1;
  dim3(unsigned all_x = 1) : x(all_x) {}
};
inline thread_local dim3 blockIdx, blockDim, threadIdx;

using cudaError_t = int;
constexpr cudaError_t cudaSuccess = 0, cudaErrorMemoryAllocation = 2, cudaErrorGraphExecUpdateFailure = 910;
const char* cudaGetErrorString(cudaError_t error);
cudaError_t cudaGetLastError();

struct cudaDeviceProp {
  char name[256];
};
cudaError_t cudaGetDeviceCount(int* count);
cudaError_t cudaSetDevice(int device);
cudaError_t cudaGetDeviceProperties(cudaDeviceProp* properties, int device);
cudaError_t cudaMemGetInfo(std::size_t* free, std::size_t* all);
cudaError_t cudaDeviceSynchronize();

enum cudaMemcpyKind { cudaMemcpyHostToDevice, cudaMemcpyDeviceToHost };
cudaError_t cudaMalloc(void** memory, std::size_t bytes);
cudaError_t cudaFree(void* memory);
cudaError_t cudaMemcpy(void* to, const void* from, std::size_t bytes, cudaMemcpyKind kind);

using cudaStream_t = struct PretendedStream*;
cudaError_t cudaLaunchKernel(const void* function, dim3 blocks, dim3 threads, void** arguments,
                             std::size_t shared_bytes, cudaStream_t stream);

using cudaGraph_t = struct PretendedGraph*;
using cudaGraphNode_t = struct PretendedNode*;
using cudaGraphExec_t = struct PretendedExec*;
struct cudaKernelNodeParams {
  void* func;
  dim3 gridDim, blockDim;
  unsigned sharedMemBytes;
  void** kernelParams;
  void** extra;
};
struct cudaGraphExecUpdateResultInfo {
  int result;
};
cudaError_t cudaGraphCreate(cudaGraph_t* graph, unsigned flags);
cudaError_t cudaGraphAddKernelNode(cudaGraphNode_t* node, cudaGraph_t graph, const cudaGraphNode_t* before,
                                   std::size_t before_count, const cudaKernelNodeParams* kernel);
cudaError_t cudaGraphInstantiate(cudaGraphExec_t* exec, cudaGraph_t graph, unsigned long long flags);
cudaError_t cudaGraphExecUpdate(cudaGraphExec_t exec, cudaGraph_t graph, cudaGraphExecUpdateResultInfo* info);
cudaError_t cudaGraphLaunch(cudaGraphExec_t exec, cudaStream_t stream);
cudaError_t cudaGraphExecDestroy(cudaGraphExec_t exec);
cudaError_t cudaGraphDestroy(cudaGraph_t graph);

namespace turgor {

/// Kernel of a count and one more argument; the runtime knows it by a pointer to this.
struct PretendedKernel {
  std::size_t argument_bytes;
  void (*call)(std::size_t count, const void* argument);  // for the thread of threadIdx
};
template <class Argument, void (*kKernel)(std::size_t, Argument)>
inline const PretendedKernel pretended_kernel{sizeof(Argument), [](std::size_t count, const void* argument) {
                                                kKernel(count, *static_cast<const Argument*>(argument));
                                              }};

/// Sets the free device memory. A larger allocation is an error of the runtime.
void pretend_memory(std::size_t bytes);
/// Counts since the start of the program: kernels run, graphs launched and created; bytes and numbers of
/// uploads and downloads.
struct PretendedCounts {
  long kernels = 0, launches = 0, graphs = 0;
  std::size_t uploaded = 0, downloaded = 0;
  long uploads = 0, downloads = 0;
};
PretendedCounts pretended_counts();

}  // namespace turgor
