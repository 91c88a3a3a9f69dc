// The volume rendering of a body's deformed CT, drawn where the CT is: for a run and for a window.
#pragma once

#include "turgor/io/files/image.hpp"
#include "turgor/sim/deformed_ct.hpp"
#include "turgor/view/device_pictures.hpp"

namespace turgor {

/// `preset` is one of volume_presets(). Error: a GPU has no room for its picture.
Result<Image> draw_deformed(const Exec& exec, const DeformedCt& ct, DevicePictures& pictures,
                            const std::string& preset, const Camera& camera, int width, int height);

/// The body alone, at the CT's own resolution.
Image draw_deformed_volume(const Exec& exec, const LatticeBody& body, const std::string& preset,
                           const Camera& camera, int width, int height);

}  // namespace turgor
