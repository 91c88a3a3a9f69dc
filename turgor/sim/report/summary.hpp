// What a run says in the terminal when it is done.
#pragma once

#include <filesystem>
#include <string>

#include "turgor/sim/report/report.hpp"

namespace turgor {

/// The quantities of a report that are marked for it, warnings, and where the results are.
std::string summary_text(const Json& report, const std::filesystem::path& folder);

}  // namespace turgor
