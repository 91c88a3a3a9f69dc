// Commands and forces of all tools, tick by tick, as a table for pandas.read_csv("forces.csv"). A scene can
// replay it (sim/tools/hand.hpp).
#pragma once

#include <filesystem>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/sim/tools/touched_body.hpp"

namespace turgor {

/// One row per tool and tick, and one before the first; the first line names the columns with their units.
Status write_forces(const std::filesystem::path& path, const std::vector<TouchingTool>& tools);

}  // namespace turgor
