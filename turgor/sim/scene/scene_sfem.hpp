// [body.NAME] of a scene, when its model is "sfem".
#pragma once

#include "turgor/sim/scene/scene_table.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"

namespace turgor {

/// PatchScene::refinement where a scene does not say: the body's elements decide.
constexpr int kByElements = 0;

/// `device`: of the scene.
SfemScene read_sfem_scene(SceneTable body, const std::string& name, Device device);

}  // namespace turgor
