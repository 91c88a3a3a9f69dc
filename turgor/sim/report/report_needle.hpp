// Needles in the report: work, shares of the force, peaks, and the force over depth.
#pragma once

#include "turgor/sim/report/json_numbers.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"
#include "turgor/sim/tools/touched_body.hpp"

namespace turgor {

/// Table of a tool that is a needle, for key `needle` of the tool.
Json needle_report(const TouchingTool& tool);

}  // namespace turgor
