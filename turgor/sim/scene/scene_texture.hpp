// Reads the table `texture` of a body.
#pragma once

#include "turgor/sim/scene/scene_table.hpp"
#include "turgor/sim/scene/texture_scene.hpp"

namespace turgor {

/// Waves or a map of heights. Error: values out of range, both of them, keys of a map without one.
void read_texture(SceneTable& body, TextureScene& texture);

}  // namespace turgor
