#include "turgor/core/gpu_run.cuh"
#include "turgor/models/lattice/device/device_body.hpp"
#include "turgor/models/lattice/device/gpu_body.hpp"

namespace turgor::lattice {

Result<std::shared_ptr<BodyBackend>> upload_model(const Gpu& gpu, const Model& model, Frames frames) {
  TURGOR_ASSERT(runs_on_gpu(model.params), "callers check runs_on_gpu");
  DeviceAllocator<GpuBackend> allocator;
  std::shared_ptr<BodyBackend> body = std::make_shared<DeviceBody<GpuBackend>>(
      model, allocator, GpuRun{.one_by_one = frames == Frames::kOneByOne});
  if (allocator.all_allocated) return body;
  return out_of_memory("the body", allocator.bytes, gpu);
}

}  // namespace turgor::lattice
