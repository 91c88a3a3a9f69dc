// [tool.NAME] of a scene: what touches a body, and along which path.
#pragma once

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

/// Why tools cannot touch a cloth: a sentence; empty = they can.
std::string why_untouched(const ClothScene& cloth);

ToolScene read_tool_scene(SceneTable tool, const std::string& name, const Scene& scene);

}  // namespace turgor
