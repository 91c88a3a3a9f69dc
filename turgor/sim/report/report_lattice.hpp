// Lattices, wounds and the deformed CT in a report. Used by report.cpp.
#pragma once

#include "turgor/sim/report/report.hpp"

namespace turgor {

Json report_body(const ReportInput& input, const LatticeScene& scene, const LatticeBody& body, BodyId id);
Json wound_report(const CutMeasures& cut);
Json solver_report(const Measures& measures);
Json deformed_report(const DeformedCtReport& deformed);

}  // namespace turgor
