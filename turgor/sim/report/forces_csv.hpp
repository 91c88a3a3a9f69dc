// What every tool felt in every tick, as a table: pandas.read_csv("forces.csv").
#pragma once

#include <filesystem>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"

namespace turgor {

/// One row a tool and tick; the first line names the columns with their units.
Status write_forces(const std::filesystem::path& path, const std::vector<TouchingTool>& tools);

}  // namespace turgor
