// The part of a report that is about bodies and the tools that touch them.
#pragma once

#include "turgor/sim/report/report.hpp"

namespace turgor {

Json report_body(const ReportInput& input, const SfemScene& scene, const SfemBody& body, BodyId id);
Json tool_report(const ToolScene& scene, const TouchingTool& tool, const World& world);

/// What a person should know before trusting the forces: sentences.
std::vector<std::string> touch_warnings(const World& world);

}  // namespace turgor
