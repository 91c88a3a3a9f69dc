#include <cuda_runtime.h>

#include "turgor/core/gpu.hpp"

namespace turgor {

Result<Gpu> open_gpu(int device) {
  int count = 0;
  if (const cudaError_t error = cudaGetDeviceCount(&count); error != cudaSuccess || count == 0)
    return Error{std::string("expected an NVIDIA GPU and its driver, found none (") +
                 cudaGetErrorString(error) + ")"};
  if (device < 0 || device >= count)
    return Error{"expected a GPU index below " + std::to_string(count) + ", found " + std::to_string(device)};
  cudaDeviceProp properties;
  std::size_t free = 0, all = 0;
  cudaError_t error = cudaSetDevice(device);
  if (error == cudaSuccess) error = cudaGetDeviceProperties(&properties, device);
  if (error == cudaSuccess) error = cudaMemGetInfo(&free, &all);
  if (error != cudaSuccess)
    return Error{"GPU " + std::to_string(device) + " does not answer: " + cudaGetErrorString(error)};
  return Gpu{device, properties.name, free};
}

void* allocate_on_gpu(std::size_t bytes) {
  void* memory = nullptr;
  if (cudaMalloc(&memory, bytes) == cudaSuccess) return memory;
  cudaGetLastError();  // the error is reported by returning null
  return nullptr;
}

void release_on_gpu(void* memory) { cudaFree(memory); }

void upload_to_gpu(void* to, const void* from, std::size_t bytes) {
  const cudaError_t error = cudaMemcpy(to, from, bytes, cudaMemcpyHostToDevice);
  TURGOR_ASSERT(error == cudaSuccess, cudaGetErrorString(error));
}

void download_from_gpu(void* to, const void* from, std::size_t bytes) {
  const cudaError_t error = cudaMemcpy(to, from, bytes, cudaMemcpyDeviceToHost);
  TURGOR_ASSERT(error == cudaSuccess, cudaGetErrorString(error));
}

}  // namespace turgor
