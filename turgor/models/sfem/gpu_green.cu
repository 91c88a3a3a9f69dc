#include "turgor/core/gpu_run.cuh"
#include "turgor/models/sfem/device_green.hpp"
#include "turgor/models/sfem/gpu_green.hpp"

namespace turgor::sfem {

namespace {

template <class T>
Status fill(const Gpu& gpu, const Model& model, std::vector<T>& values, const Progress& progress) {
  DeviceAllocator<GpuSide> rooms;
  DeviceGreen<GpuSide, T> there(model, rooms);
  if (!rooms.all_allocated) return no_room("the store of Green's functions", rooms.bytes, gpu);
  there.fill(values, progress);
  return Done{};
}

}  // namespace

Status fill_green_on(const Gpu& gpu, Model& model, const Progress& progress) {
  Green& green = model.green;
  return model.params.precision == Precision::kSingle ? fill(gpu, model, green.single_values, progress)
                                                      : fill(gpu, model, green.double_values, progress);
}

}  // namespace turgor::sfem
