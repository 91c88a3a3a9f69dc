// From a scene to a body that can be touched: its shape from a file, a surface, a segmentation or a block;
// its Green's functions from the cache or computed; its tools on their paths.
#pragma once

#include <functional>
#include <string>

#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/core/result.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"
#include "turgor/sim/tools/press_path.hpp"

namespace turgor {

/// Called before work that takes long: a word for a progress bar, and a sentence that says what it will take
/// (may be empty). Returns what is told the finished fraction; both may be empty.
using BeginWork = std::function<Progress(const std::string& label, const std::string& sentence)>;

/// Without its tools. Error: names the scene's place, or the file.
Result<SfemBody> load_sfem(const Exec& exec, const SfemScene& scene, const BeginWork& begin);

/// A tool by its shape alone, to be drawn. Error: a mesh that is none.
Result<TouchingTool> load_tool_shape(const ToolScene& scene);
/// A tool, with its path laid on the surface of the body of that name. Error: a path or a mesh that is none,
/// a tool wider than the body.
Result<TouchingTool> load_tool(const ToolScene& scene, const std::string& body, const RestSurface& surface);

/// The surface that tools touch.
RestSurface rest_surface(const SfemBody& body);

}  // namespace turgor
