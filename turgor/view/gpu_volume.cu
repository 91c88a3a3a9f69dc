#include "turgor/core/gpu_run.cuh"
#include "turgor/view/device_volume.hpp"
#include "turgor/view/gpu_volume.hpp"

namespace turgor {

std::unique_ptr<VolumeBackend> volume_on(const Gpu&) { return std::make_unique<DeviceVolume<GpuBackend>>(); }

}  // namespace turgor
