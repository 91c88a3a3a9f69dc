// Touched bodies of all models side by side: the dents under their largest forces, and what they cost.
#pragma once

#include "turgor/sim/report/report.hpp"

namespace turgor {

/// From one force to the next: bodies answer every tick, lattices every frame [s].
double force_interval(const World& world, BodyId id);

/// So many of 1 took less [s]; null when none was measured: in real time the loop's report has them.
Json wall_time(const std::vector<double>& seconds, double part);

/// Displacement over distance from the place that moved most, when the force was largest.
Json profile_report(const Measures& measures);
/// Building, one force, one surface; the largest force and how deep it was.
Json cost_report(const World& world, const Measures& measures);

}  // namespace turgor
