// A tool of the scene: its shape, and its path laid on the body that it touches.
#pragma once

#include <string>

#include "turgor/core/result.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"
#include "turgor/sim/tools/press_path.hpp"
#include "turgor/sim/tools/touched_body.hpp"

namespace turgor {

/// A tool by its shape alone, to be drawn. Error: a mesh that is none.
Result<TouchingTool> load_tool_shape(const ToolScene& scene);
/// A tool, with its path laid on the surface of the body of that name. Error: a path or a mesh that is none,
/// a tool wider than the body.
Result<TouchingTool> load_tool(const ToolScene& scene, const std::string& body, const RestSurface& surface);

}  // namespace turgor
