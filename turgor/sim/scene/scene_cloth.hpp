// Reads [body.NAME] with model = "cloth". Used by scene.cpp alone.
#pragma once

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

/// Bodies of the scene that come before it may be lain on.
ClothScene read_cloth_scene(SceneTable body, const std::string& name, const Scene& scene);

}  // namespace turgor
