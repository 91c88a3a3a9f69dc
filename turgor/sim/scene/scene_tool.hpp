// Reads [tool.NAME]: shape, body and motion of a tool.
#pragma once

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

/// Reason why tools cannot touch a cloth; empty if they can.
std::string why_untouched(const ClothScene& cloth);

ToolScene read_tool_scene(SceneTable tool, const std::string& name, const Scene& scene);

}  // namespace turgor
