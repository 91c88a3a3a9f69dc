// Needles in the report: work, shares of the force, peaks, and the force over depth.
#pragma once

#include "turgor/sim/bodies/lattice/lattice_body.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"
#include "turgor/sim/report/json_numbers.hpp"
#include "turgor/sim/tools/touched_body.hpp"

namespace turgor {

/// Table of a tool that is a needle, for key `needle` of the tool.
Json needle_report(const TouchingTool& tool, const SfemBody& body);
Json needle_report(const TouchingTool& tool, const LatticeBody& body);

}  // namespace turgor
