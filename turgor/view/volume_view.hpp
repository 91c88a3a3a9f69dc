// Volume rendering of CTs on the CPU: rays through every pixel, in parallel over tiles. Volumes may have any
// spacing and oblique axes. The picture is bit-identical for any number of threads.
#pragma once

#include <string>

#include "turgor/core/exec.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/io/files/image.hpp"
#include "turgor/view/camera.hpp"
#include "turgor/view/transfer.hpp"

namespace turgor {

/// `preset` is one of volume_presets().
Image draw_volume(const Exec& exec, const CtVolume& ct, const std::string& preset, const Camera& camera,
                  int width, int height);

}  // namespace turgor
