// The part of a report that is about cloth.
#pragma once

#include "turgor/sim/report/report.hpp"

namespace turgor {

Json report_body(const ReportInput& input, const ClothScene& scene, const ClothBody& body, BodyId id);
/// What the reader of a report should know before believing it.
std::vector<std::string> cloth_warnings(const World& world);

namespace page {
/// Key figures, curves and tables of cloths; empty when there are none.
std::string cloth_figures(const Json& report);
std::string cloth_curves(const Json& report);
std::string cloth_tables(const Json& report);
}  // namespace page

}  // namespace turgor
