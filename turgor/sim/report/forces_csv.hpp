// What every tool did and felt in every tick, as a table: pandas.read_csv("forces.csv"). A scene can replay
// it (sim/tools/hand.hpp).
#pragma once

#include <filesystem>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/sim/tools/touched_body.hpp"

namespace turgor {

/// One row a tool and tick, and one before the first; the first line names the columns with their units.
Status write_forces(const std::filesystem::path& path, const std::vector<TouchingTool>& tools);

}  // namespace turgor
