// What a run's report must say for the run to count: "haptics.missed<0.001". A gate for CI.
#pragma once

#include <string>

#include "turgor/core/result.hpp"
#include "turgor/sim/report/report.hpp"

namespace turgor {

/// A number of the report, and where it must be.
struct Requirement {
  std::string key;  // names with dots between; an entry of a list by its "name", or by its number from 0
  std::string comparison;  // "<", "<=", ">" or ">="
  double bound = 0;
};

/// Error: what was expected and found.
Result<Requirement> read_requirement(const std::string& text);

/// Empty when it holds, else a sentence that says by how much not. Error: the report has no such number.
Result<std::string> missed_by(const Json& report, const Requirement& requirement);

}  // namespace turgor
