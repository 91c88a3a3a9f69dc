#include "turgor/core/gpu_run.cuh"
#include "turgor/models/cloth/device/device_sheet.hpp"
#include "turgor/models/cloth/device/gpu_sheet.hpp"

namespace turgor::cloth {

Result<std::shared_ptr<SheetBackend>> put(const Gpu& gpu, const Model& model) {
  TURGOR_ASSERT(why_not_on_gpu(model.params).key.empty(), "asked before by why_not_on_gpu");
  DeviceAllocator<GpuSide> rooms;
  std::shared_ptr<SheetBackend> sheet = std::make_shared<DeviceSheet<GpuSide>>(model, rooms);
  if (rooms.all_allocated) return sheet;
  return no_room("the cloth", rooms.bytes, gpu);
}

}  // namespace turgor::cloth
