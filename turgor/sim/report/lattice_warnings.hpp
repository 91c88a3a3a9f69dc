// What a run knows of its lattices that makes their figures doubtful.
#pragma once

#include <string>
#include <vector>

#include "turgor/sim/world.hpp"

namespace turgor {

/// Folded cells; blades that were set on the skin far from where the scene has them, or cut nearly through.
std::vector<std::string> lattice_warnings(const Exec& exec, const World& world);

}  // namespace turgor
