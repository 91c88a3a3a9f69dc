// Bodies of the rhombus model in a report. Used by report.cpp.
#pragma once

#include "turgor/sim/report/report.hpp"

namespace turgor {

Json report_body(const ReportInput& input, const RhombusScene& scene, const RhombusBody& body, BodyId id);

}  // namespace turgor
