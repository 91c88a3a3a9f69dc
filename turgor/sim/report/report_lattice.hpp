// Lattices, their wounds and the deformed CT in a report. Used by report.cpp.
#pragma once

#include "turgor/sim/report/report.hpp"

namespace turgor {

Json lattice_report(const LatticeScene& scene, const LatticeBody& body);
Json wound_report(const CutMeasures& cut);
Json solver_report(const Measures& measures);
Json deformed_report(const DeformedCtReport& deformed);

}  // namespace turgor
