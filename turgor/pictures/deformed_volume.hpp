// The volume rendering of a body's deformed CT, drawn where the body is.
#pragma once

#include "turgor/io/image.hpp"
#include "turgor/sim/world.hpp"
#include "turgor/view/camera.hpp"

namespace turgor {

/// The body alone, at the CT's own resolution; `preset` is one of volume_presets().
Image draw_deformed_volume(const Exec& exec, const LatticeBody& body, const std::string& preset,
                           const Camera& camera, int width, int height);

}  // namespace turgor
