#include "turgor/core/gpu_run.cuh"
#include "turgor/models/cloth/gpu_sheet.hpp"
#include "turgor/models/cloth/sheet_on.hpp"

namespace turgor::cloth {

Result<std::shared_ptr<SheetThere>> put(const Gpu& gpu, const Model& model) {
  TURGOR_ASSERT(why_not_on_gpu(model.params).key.empty(), "asked before by why_not_on_gpu");
  Rooms<GpuSide> rooms;
  std::shared_ptr<SheetThere> sheet = std::make_shared<SheetOn<GpuSide>>(model, rooms);
  if (rooms.all_there) return sheet;
  return no_room("the cloth", rooms.bytes, gpu);
}

}  // namespace turgor::cloth
