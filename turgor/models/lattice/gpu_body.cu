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
  const auto megabytes = [](std::size_t bytes) { return std::to_string(bytes / 1000000) + " MB"; };
  return Error{"the body needs " + megabytes(rooms.bytes) + " of a GPU's memory; " + gpu.name + " has " +
               megabytes(gpu.free_bytes) + " free"};
}

}  // namespace turgor::lattice
