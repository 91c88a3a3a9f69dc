// Volume rendering of a body's deformed CT, on the host or on the device that holds it. Runs and windows use
// it.
#pragma once

#include "turgor/io/files/image.hpp"
#include "turgor/sim/deformed_ct.hpp"
#include "turgor/view/device_pictures.hpp"

namespace turgor {

/// `preset` is one of volume_presets(). Error: GPU memory is short for the picture.
Result<Image> draw_deformed(const Exec& exec, const DeformedCt& ct, DevicePictures& pictures,
                            const std::string& preset, const Camera& camera, int width, int height);

/// Only the body, at the CT's own resolution.
Image draw_deformed_volume(const Exec& exec, const LatticeBody& body, const std::string& preset,
                           const Camera& camera, int width, int height);

}  // namespace turgor
