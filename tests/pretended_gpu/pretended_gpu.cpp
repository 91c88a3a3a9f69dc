#include <algorithm>
#include <atomic>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <sys/mman.h>
#include <unistd.h>

#include "cuda_runtime.h"
#include "turgor/core/exec.hpp"
#include "turgor/core/flush_denormals.hpp"

struct PretendedNode {
  const turgor::PretendedKernel* kernel;
  dim3 blocks, threads;
  std::size_t count;
  std::vector<std::max_align_t> argument;
};
struct PretendedGraph {
  std::vector<std::unique_ptr<PretendedNode>> nodes;
};
struct PretendedExec {
  std::vector<PretendedNode> nodes;
};

namespace {

using turgor::PretendedCounts;
using turgor::PretendedKernel;

/// Whole pages, followed by a protected page; arrays end where it begins.
struct Pages {
  std::byte* begin;
  std::size_t bytes, array_bytes;
};
struct Memory {
  std::mutex mutex;
  std::map<void*, Pages> arrays;
  std::size_t free = std::size_t(8) << 30;
  int open = 0;
};
Memory& memory() {
  static Memory* all = new Memory;  // outlives the destructors of arrays at the end of the program
  return *all;
}
std::atomic<long> kernels = 0, launches = 0, graphs = 0, uploads = 0, downloads = 0;
std::atomic<std::size_t> uploaded = 0, downloaded = 0;
thread_local cudaError_t last_error = cudaSuccess;

cudaError_t set_error(cudaError_t error) {
  if (error != cudaSuccess) last_error = error;
  return error;
}

void protect(const Pages& pages, int how) { mprotect(pages.begin, pages.bytes, how); }

/// While one exists, device memory is accessible.
struct Open {
  Open() {
    const std::lock_guard lock(memory().mutex);
    if (memory().open++ == 0)
      for (const auto& [array, pages] : memory().arrays) protect(pages, PROT_READ | PROT_WRITE);
  }
  Open(const Open&) = delete;
  Open& operator=(const Open&) = delete;
  ~Open() {
    const std::lock_guard lock(memory().mutex);
    if (--memory().open == 0)
      for (const auto& [array, pages] : memory().arrays) protect(pages, PROT_NONE);
  }
};

using Argument = std::vector<std::max_align_t>;
Argument copy_of(const PretendedKernel& kernel, const void* argument) {
  Argument copy(kernel.argument_bytes / sizeof(std::max_align_t) + 1);
  std::memcpy(copy.data(), argument, kernel.argument_bytes);
  return copy;
}
/// A pool gives a short loop to one thread; ThreadSanitizer needs two.
template <class Body>
void for_slices(std::size_t count, const Body& body) {
#ifdef __SANITIZE_THREAD__
  std::thread odd([&] {
    for (std::size_t n = 1; n < count; n += 2) body(n);
  });
  for (std::size_t n = 0; n < count; n += 2) body(n);
  odd.join();
#else
  static const turgor::Exec exec(4);
  turgor::parallel_for(exec, count, body);
#endif
}

/// Neighboring device threads run on different host threads; the last ones run first.
void run(const PretendedKernel& kernel, dim3 blocks, dim3 threads, std::size_t count, const void* argument) {
  constexpr std::size_t kSlices = 7;
  kernels++;
  const std::size_t all = std::size_t(blocks.x) * threads.x;
  for_slices(std::min(all, kSlices), [&](std::size_t first) {
    const turgor::FlushDenormals flush;  // as GPUs do
    blockDim = threads;
    for (std::size_t n = first + (all - 1 - first) / kSlices * kSlices;; n -= kSlices) {
      blockIdx.x = unsigned(n / threads.x), threadIdx.x = unsigned(n % threads.x);
      kernel.call(count, argument);
      if (n == first) break;
    }
  });
}

bool is_a_launch(dim3 blocks, dim3 threads) {
  return blocks.x > 0 && blocks.x <= 0x7fffffffu && threads.x > 0 && threads.x <= 1024;
}

}  // namespace

const char* cudaGetErrorString(cudaError_t error) {
  return error == cudaSuccess                 ? "no error"
         : error == cudaErrorMemoryAllocation ? "out of memory"
                                              : "an error of a pretended GPU";
}
cudaError_t cudaGetLastError() { return std::exchange(last_error, cudaSuccess); }
cudaError_t cudaGetDeviceCount(int* count) {
  *count = 1;
  return cudaSuccess;
}
cudaError_t cudaSetDevice(int device) { return set_error(device == 0 ? cudaSuccess : 101); }
cudaError_t cudaGetDeviceProperties(cudaDeviceProp* properties, int) {
  std::strcpy(properties->name, "a pretended GPU");
  return cudaSuccess;
}
cudaError_t cudaMemGetInfo(std::size_t* free, std::size_t* all) {
  const std::lock_guard lock(memory().mutex);
  *free = memory().free, *all = std::size_t(8) << 30;
  return cudaSuccess;
}
cudaError_t cudaDeviceSynchronize() { return cudaSuccess; }

cudaError_t cudaMalloc(void** to, std::size_t bytes) {
  constexpr std::size_t kAlignment = 16;
  *to = nullptr;
  if (bytes == 0) return cudaSuccess;
  const auto page = std::size_t(sysconf(_SC_PAGESIZE));
  const std::size_t used = (bytes + page - 1) / page * page;
  const std::lock_guard lock(memory().mutex);
  if (bytes > memory().free) return set_error(cudaErrorMemoryAllocation);
  void* begin = mmap(nullptr, used + page, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (begin == MAP_FAILED) return set_error(cudaErrorMemoryAllocation);
  const Pages pages{static_cast<std::byte*>(begin), used, bytes};
  mprotect(begin, used, PROT_READ | PROT_WRITE);
  std::memset(begin, 0xab, used);  // uninitialized memory is not zero
  if (memory().open == 0) protect(pages, PROT_NONE);
  *to = pages.begin + (used - bytes) / kAlignment * kAlignment;
  memory().arrays.emplace(*to, pages);
  memory().free -= bytes;
  return cudaSuccess;
}
cudaError_t cudaFree(void* array) {
  if (array == nullptr) return cudaSuccess;
  const std::lock_guard lock(memory().mutex);
  const auto found = memory().arrays.find(array);
  if (found == memory().arrays.end()) return set_error(1);
  const Pages pages = found->second;
  munmap(pages.begin, pages.bytes + std::size_t(sysconf(_SC_PAGESIZE)));
  memory().free += pages.array_bytes;
  memory().arrays.erase(found);
  return cudaSuccess;
}
cudaError_t cudaMemcpy(void* to, const void* from, std::size_t bytes, cudaMemcpyKind kind) {
  const std::byte* device_memory = static_cast<const std::byte*>(kind == cudaMemcpyHostToDevice ? to : from);
  {
    const std::lock_guard lock(memory().mutex);
    const auto behind = memory().arrays.upper_bound(const_cast<std::byte*>(device_memory));
    if (behind == memory().arrays.begin()) return set_error(1);
    const auto& [array, pages] = *std::prev(behind);
    if (device_memory + bytes > static_cast<const std::byte*>(array) + pages.array_bytes) return set_error(1);
  }
  const Open open;
  std::memcpy(to, from, bytes);
  (kind == cudaMemcpyHostToDevice ? uploaded : downloaded) += bytes;
  (kind == cudaMemcpyHostToDevice ? uploads : downloads)++;
  return cudaSuccess;
}

cudaError_t cudaLaunchKernel(const void* function, dim3 blocks, dim3 threads, void** arguments, std::size_t,
                             cudaStream_t) {
  if (!is_a_launch(blocks, threads)) return set_error(9);
  const auto& kernel = *static_cast<const PretendedKernel*>(function);
  const Open open;
  run(kernel, blocks, threads, *static_cast<const std::size_t*>(arguments[0]), arguments[1]);
  return cudaSuccess;
}

cudaError_t cudaGraphCreate(cudaGraph_t* graph, unsigned) {
  *graph = new PretendedGraph;
  return cudaSuccess;
}
cudaError_t cudaGraphAddKernelNode(cudaGraphNode_t* node, cudaGraph_t graph, const cudaGraphNode_t* before,
                                   std::size_t before_count, const cudaKernelNodeParams* params) {
  if (!is_a_launch(params->gridDim, params->blockDim)) return set_error(9);
  const bool is_chain =
      graph->nodes.empty() ? before_count == 0 : before_count == 1 && *before == graph->nodes.back().get();
  if (!is_chain) return set_error(1);
  const auto* kernel = static_cast<const PretendedKernel*>(params->func);
  auto made = std::make_unique<PretendedNode>(PretendedNode{
      kernel, params->gridDim, params->blockDim, *static_cast<const std::size_t*>(params->kernelParams[0]),
      copy_of(*kernel, params->kernelParams[1])});
  *node = made.get();
  graph->nodes.push_back(std::move(made));
  return cudaSuccess;
}
namespace {

void take(PretendedExec& exec, PretendedGraph& graph) {
  exec.nodes.clear();
  for (const auto& node : graph.nodes) exec.nodes.push_back(std::move(*node));
}

}  // namespace
cudaError_t cudaGraphInstantiate(cudaGraphExec_t* exec, cudaGraph_t graph, unsigned long long) {
  *exec = new PretendedExec;
  take(**exec, *graph);
  graphs++;
  return cudaSuccess;
}
cudaError_t cudaGraphExecUpdate(cudaGraphExec_t exec, cudaGraph_t graph, cudaGraphExecUpdateResultInfo*) {
  if (exec->nodes.size() != graph->nodes.size()) return set_error(cudaErrorGraphExecUpdateFailure);
  take(*exec, *graph);
  return cudaSuccess;
}
cudaError_t cudaGraphLaunch(cudaGraphExec_t exec, cudaStream_t) {
  const Open open;
  for (const PretendedNode& node : exec->nodes)
    run(*node.kernel, node.blocks, node.threads, node.count, node.argument.data());
  launches++;
  return cudaSuccess;
}
cudaError_t cudaGraphExecDestroy(cudaGraphExec_t exec) {
  delete exec;
  return cudaSuccess;
}
cudaError_t cudaGraphDestroy(cudaGraph_t graph) {
  delete graph;
  return cudaSuccess;
}

namespace turgor {

void pretend_memory(std::size_t bytes) {
  const std::lock_guard lock(memory().mutex);
  memory().free = bytes;
}
PretendedCounts pretended_counts() {
  return {kernels, launches, graphs, uploaded, downloaded, uploads, downloads};
}

}  // namespace turgor
