// Reads [body.NAME] with model = "rhombus".
#pragma once

#include "turgor/sim/scene/rhombus_scene.hpp"
#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

/// Requires that bodies with model = "sfem" were read.
RhombusScene read_rhombus_scene(SceneTable body, const std::string& name, const Scene& scene);

}  // namespace turgor
