// When a tool pressed on a place below which a part of another material lies: what its curves mark.
#pragma once

#include <vector>

#include "turgor/sim/bodies/sfem/inner_parts.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/tools/touch_log.hpp"

namespace turgor {

/// Stretches of ticks in which the line along the force on the tool went through the ball of a part, however
/// deep: [{"part", "from_s", "to_s", "from_mm", "to_mm"}], the last two of the tool's path.
Json over_parts(const TouchLog& ticks, const std::vector<InnerPart>& parts);

}  // namespace turgor
