// Organs of the rhombus model in report.json, and models side by side. Used by report.cpp.
#pragma once

#include "turgor/sim/report.hpp"

namespace turgor {

Json rhombus_report(const RhombusScene& scene, const RhombusOrgan& organ);

/// Of every organ under its largest force: displacement over the distance from where it is pressed most.
Json profile_report(const World& world);

/// Of the surfaces as they lie now: equal bits give equal hashes.
std::uint64_t rhombus_hash(const World& world);

}  // namespace turgor
