// Replaces gpu.cu in builds without nvcc.
#include "turgor/core/gpu.hpp"

namespace turgor {

Result<Gpu> open_gpu(int) {
  return Error{
      "expected a build of turgor with CUDA (cmake -DTURGOR_CUDA=ON, nvcc 12 or newer), found one without"};
}

void* allocate_on_gpu(std::size_t) { return nullptr; }
void release_on_gpu(void*) {}
void upload_to_gpu(void*, const void*, std::size_t) {}
void download_from_gpu(void*, const void*, std::size_t) {}

}  // namespace turgor
