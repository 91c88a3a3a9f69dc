#include "turgor/core/gpu_run.cuh"
#include "turgor/models/sfem/device_green.hpp"
#include "turgor/models/sfem/gpu_green.hpp"

namespace turgor::sfem {

namespace {

template <class T>
Status fill(const Gpu& gpu, const Model& model, std::vector<T>& values, const Progress& progress) {
  DeviceAllocator<GpuBackend> allocator;
  DeviceGreen<GpuBackend, T> device(model, allocator);
  if (!allocator.all_allocated) return out_of_memory("the store of Green's functions", allocator.bytes, gpu);
  device.fill(values, progress);
  return Done{};
}

}  // namespace

Status fill_green_on_device(const Gpu& gpu, Model& model, const Progress& progress) {
  Green& green = model.green;
  return model.params.precision == Precision::kSingle ? fill(gpu, model, green.single_values, progress)
                                                      : fill(gpu, model, green.double_values, progress);
}

}  // namespace turgor::sfem
