// Requirements on a report, such as "haptics.missed<0.001": a gate for CI.
#pragma once

#include <string>

#include "turgor/core/result.hpp"
#include "turgor/sim/report/report.hpp"

namespace turgor {

/// Bound of a number in the report.
struct Requirement {
  std::string key;         // names separated by dots; an entry of a list by its "name", or by its index
  std::string comparison;  // "<", "<=", ">" or ">="
  double bound = 0;
};

/// Error: what was expected and found.
Result<Requirement> read_requirement(const std::string& text);

/// Empty if the requirement holds, else a sentence with the value. Error: the report has no such number.
Result<std::string> missed_by(const Json& report, const Requirement& requirement);

}  // namespace turgor
