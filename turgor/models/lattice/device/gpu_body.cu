#include "turgor/core/gpu_run.cuh"
#include "turgor/models/lattice/device/device_body.hpp"
#include "turgor/models/lattice/device/gpu_body.hpp"

namespace turgor::lattice {

Result<std::shared_ptr<BodyBackend>> put(const Gpu& gpu, const Model& model, Frames frames) {
  TURGOR_ASSERT(runs_on_gpu(model.params), "asked before by runs_on_gpu");
  DeviceAllocator<GpuSide> rooms;
  std::shared_ptr<BodyBackend> body =
      std::make_shared<DeviceBody<GpuSide>>(model, rooms, GpuRun{.one_by_one = frames == Frames::kOneByOne});
  if (rooms.all_allocated) return body;
  return no_room("the body", rooms.bytes, gpu);
}

}  // namespace turgor::lattice
