#include "turgor/view/gpu_volume.hpp"

#include "turgor/core/gpu_run.cuh"
#include "turgor/view/volume_on.hpp"

namespace turgor {

std::unique_ptr<VolumeThere> volume_on(const Gpu&) { return std::make_unique<VolumeOn<GpuSide>>(); }

}  // namespace turgor
