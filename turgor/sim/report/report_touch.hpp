// Tools in a report.
#pragma once

#include "turgor/sim/report/report.hpp"

namespace turgor {

Json tool_report(const ToolScene& scene, const TouchingTool& tool, const World& world);

/// Warnings about limits of the haptic devices that the scene names.
std::vector<std::string> device_warnings(const Scene& scene, const World& world);
/// Warnings about the reliability of forces.
std::vector<std::string> touch_warnings(const World& world);

}  // namespace turgor
