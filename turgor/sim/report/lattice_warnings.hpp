// Warnings about lattice results that are unreliable.
#pragma once

#include <string>
#include <vector>

#include "turgor/sim/world.hpp"

namespace turgor {

/// Warnings about inverted cells, blades far from their given position, and cuts through almost the whole
/// body.
std::vector<std::string> lattice_warnings(const Exec& exec, const World& world);

}  // namespace turgor
