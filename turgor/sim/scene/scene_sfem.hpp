// Reads [body.NAME] with model = "sfem".
#pragma once

#include "turgor/sim/scene/scene_table.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"

namespace turgor {

/// PatchScene::refinement if the scene does not set it: the element order decides.
constexpr int kByElements = 0;

/// `device`: from the scene.
SfemScene read_sfem_scene(SceneTable body, const std::string& name, Device device);

}  // namespace turgor
