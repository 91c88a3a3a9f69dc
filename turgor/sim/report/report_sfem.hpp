// Bodies of finite elements in a report. Used by report.cpp.
#pragma once

#include "turgor/sim/report/report.hpp"

namespace turgor {

Json report_body(const ReportInput& input, const SfemScene& scene, const SfemBody& body, BodyId id);

}  // namespace turgor
