// Comparison of touched bodies of all models: displacements under the largest forces, and costs.
#pragma once

#include "turgor/sim/report/report.hpp"

namespace turgor {

/// Interval of forces: one per tick on elements and chains, one per frame on other bodies [s].
double force_interval(const World& world, BodyId id);

/// Percentile at `fraction` [s]; null without samples: in real time the report of the loop contains them.
Json wall_time(const std::vector<double>& seconds, double fraction);

/// Displacement over the distance from the most displaced vertex, under the largest force.
Json profile_report(const Measures& measures);
/// Times of building, of a force and of a surface; the largest force and its depth.
Json cost_report(const World& world, const Measures& measures);

}  // namespace turgor
