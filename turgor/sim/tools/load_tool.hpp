// Loads a tool of the scene: its shape, and its path on the touched body.
#pragma once

#include <string>

#include "turgor/core/result.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"
#include "turgor/sim/tools/press_path.hpp"
#include "turgor/sim/tools/touched_body.hpp"

namespace turgor {

/// Tool without a path, for drawing. Error: an invalid mesh.
Result<TouchingTool> load_tool_shape(const ToolScene& scene);
/// Tool with its path on the surface of the body of that name. Error: an invalid path or mesh, or a tool of
/// ten times the body's width.
Result<TouchingTool> load_tool(const ToolScene& scene, const std::string& body, const RestSurface& surface);

}  // namespace turgor
