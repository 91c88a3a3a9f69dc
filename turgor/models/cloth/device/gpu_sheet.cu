#include "turgor/core/gpu_run.cuh"
#include "turgor/models/cloth/device/device_sheet.hpp"
#include "turgor/models/cloth/device/gpu_sheet.hpp"

namespace turgor::cloth {

Result<std::shared_ptr<SheetBackend>> put(const Gpu& gpu, const Model& model) {
  TURGOR_ASSERT(why_not_on_gpu(model.params).key.empty(), "callers check why_not_on_gpu first");
  DeviceAllocator<GpuBackend> allocator;
  std::shared_ptr<SheetBackend> sheet = std::make_shared<DeviceSheet<GpuBackend>>(model, allocator);
  if (allocator.all_allocated) return sheet;
  return out_of_memory("the cloth", allocator.bytes, gpu);
}

}  // namespace turgor::cloth
