// Loads the texture of a touched surface.
#pragma once

#include "turgor/contact/texture.hpp"
#include "turgor/core/result.hpp"
#include "turgor/sim/scene/texture_scene.hpp"

namespace turgor {

/// Waves of the scene, or the map of its file. Error: file and line of a row that has another length or is no
/// row of numbers, more than 4 million samples, or heights beyond 1 mm of their mean.
Result<contact::Texture> load_texture(const TextureScene& scene);

}  // namespace turgor
