// [body.NAME] of a scene, when its model is "sfem".
#pragma once

#include "turgor/sim/scene/scene_table.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"

namespace turgor {

SfemScene read_sfem_scene(SceneTable body, const std::string& name);

}  // namespace turgor
