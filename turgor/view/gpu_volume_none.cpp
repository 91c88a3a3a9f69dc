// Replaces gpu_volume.cu in builds without nvcc; never called, because open_gpu fails.
#include "turgor/view/gpu_volume.hpp"

namespace turgor {

std::unique_ptr<VolumeBackend> volume_on(const Gpu&) { return nullptr; }

}  // namespace turgor
