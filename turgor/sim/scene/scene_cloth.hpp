// Reads [body.NAME] with model = "cloth". Used by scene.cpp only.
#pragma once

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

/// Obstacles may refer to bodies of `scene`, which are read before.
ClothScene read_cloth_scene(SceneTable body, const std::string& name, const Scene& scene);

}  // namespace turgor
