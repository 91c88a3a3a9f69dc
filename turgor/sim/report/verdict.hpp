// Verdict of a run: first the answer, then how far to trust it. Made from report.json only.
#pragma once

#include <string>
#include <vector>

#include "turgor/sim/report/json_numbers.hpp"

namespace turgor {

/// Two sentences for each kind of body that has results: is the wound or the cloth at rest, how large is the
/// largest force, and the error that the solver or the mesh left. Never empty.
std::vector<std::string> verdict_of(const Json& report);

}  // namespace turgor
