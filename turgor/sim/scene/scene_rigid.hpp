// Reads [body.NAME] with model = "rigid". Used by scene.cpp alone.
#pragma once

#include "turgor/sim/scene/rigid_scene.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

RigidScene read_rigid_scene(SceneTable body, const std::string& name);

}  // namespace turgor
