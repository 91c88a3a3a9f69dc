// Summary of a run for the terminal.
#pragma once

#include <filesystem>
#include <string>

#include "turgor/sim/report/report.hpp"

namespace turgor {

/// Quantities marked for the summary, warnings, and the locations of results.
std::string summary_text(const Json& report, const std::filesystem::path& folder);

}  // namespace turgor
