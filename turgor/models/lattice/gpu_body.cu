#include "turgor/core/gpu_run.cuh"
#include "turgor/models/lattice/body_on.hpp"
#include "turgor/models/lattice/gpu_body.hpp"

namespace turgor::lattice {

Result<std::shared_ptr<BodyThere>> put(const Gpu& gpu, const Model& model, Frames frames) {
  TURGOR_ASSERT(runs_on_gpu(model.params), "asked before by runs_on_gpu");
  Rooms<GpuSide> rooms;
  std::shared_ptr<BodyThere> body =
      std::make_shared<BodyOn<GpuSide>>(model, rooms, GpuRun{.one_by_one = frames == Frames::kOneByOne});
  if (rooms.all_there) return body;
  return no_room("the body", rooms.bytes, gpu);
}

}  // namespace turgor::lattice
