// The part of a report that is about bodies and the tools that touch them.
#pragma once

#include "turgor/sim/report/report.hpp"

namespace turgor {

Json sfem_report(const SfemScene& scene, const SfemBody& body);
Json tool_report(const ToolScene& scene, const TouchingTool& tool, const World& world);

/// What a person should know before trusting the forces: sentences.
std::vector<std::string> touch_warnings(const World& world);

/// Of what lies on and between the surfaces now: equal bits give equal hashes.
std::uint64_t touch_hash(const World& world);

}  // namespace turgor
