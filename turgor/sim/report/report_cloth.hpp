// The part of a report that is about cloth.
#pragma once

#include "turgor/sim/report/report.hpp"

namespace turgor {

Json report_body(const ReportInput& input, const ClothScene& scene, const ClothBody& body, BodyId id);
/// What the reader of a report should know before believing it.
std::vector<std::string> cloth_warnings(const World& world);

namespace page {
/// Empty when there is no cloth.
std::string cloth_curves(const Json& report);
}  // namespace page

}  // namespace turgor
