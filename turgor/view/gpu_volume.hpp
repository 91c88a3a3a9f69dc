// Volume rendering on a GPU: the picture of draw_volume, but for how fused multiply-adds and its exponentials
// round.
#pragma once

#include <memory>

#include "turgor/core/gpu.hpp"
#include "turgor/view/volume_backend.hpp"

namespace turgor {

std::unique_ptr<VolumeBackend> volume_on(const Gpu& gpu);

}  // namespace turgor
