// How far off the force of a tool on finite elements is to be expected, because they are as large as they
// are, and what to do where that is much.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turgor/models/sfem/expected_error.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// What a ball or a rod touched at its deepest; none of tools of other shapes, of other bodies, and of what
/// did not touch.
std::optional<sfem::TouchedElements> touched_elements(const World& world, const TouchingTool& tool);

/// A sentence for every tool whose force may be more than 10 % off.
std::vector<std::string> coarse_presses(const World& world);

}  // namespace turgor
