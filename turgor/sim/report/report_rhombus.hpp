// Bodies of the rhombus model in report.json. Used by report.cpp.
#pragma once

#include "turgor/sim/report/report.hpp"

namespace turgor {

Json rhombus_report(const RhombusScene& scene, const RhombusBody& body);

/// Of the surfaces as they lie now: equal bits give equal hashes.
std::uint64_t rhombus_hash(const World& world);

}  // namespace turgor
