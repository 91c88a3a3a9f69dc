// Volume rendering on a GPU: the picture of draw_volume up to rounding (fused multiply-adds and exponentials
// differ).
#pragma once

#include <memory>

#include "turgor/core/gpu.hpp"
#include "turgor/view/volume_backend.hpp"

namespace turgor {

std::unique_ptr<VolumeBackend> volume_on(const Gpu& gpu);

}  // namespace turgor
