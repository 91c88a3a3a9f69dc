// Cloth in a report.
#pragma once

#include "turgor/sim/report/report.hpp"

namespace turgor {

Json report_body(const ReportInput& input, const ClothScene& scene, const ClothBody& body, BodyId id);
/// Warnings about unreliable results of cloth.
std::vector<std::string> cloth_warnings(const World& world);

namespace page {
/// Empty without cloth.
std::string cloth_curves(const Json& report);
}  // namespace page

}  // namespace turgor
