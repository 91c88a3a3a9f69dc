// Intervals in which a tool pressed above an inclusion, for marks in force curves.
#pragma once

#include <vector>

#include "turgor/sim/bodies/sfem/inner_regions.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/tools/touch_log.hpp"

namespace turgor {

/// Intervals of ticks in which the line of force passed through the sphere of an inclusion, at any depth:
/// [{"inclusion", "from_s", "to_s", "from_mm", "to_mm"}]; the last two are lengths of the tool's path.
Json over_inclusions(const TouchLog& ticks, const std::vector<InnerRegion>& inclusions);

}  // namespace turgor
