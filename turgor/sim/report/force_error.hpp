// How far off the force of a tool on finite elements is to be expected, because they are as large as they
// are, and what to do where that is much.
#pragma once

#include <optional>
#include <string>

#include "turgor/models/sfem/expected_error.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// What a ball or a rod touched at its deepest; none of tools of other shapes, of other bodies, and of what
/// did not touch.
std::optional<sfem::TouchedElements> touched_elements(const World& world, const TouchingTool& tool);

/// Empty when its force is within 10 % or nothing is known of it; else a sentence.
std::string coarse_below(const World& world, const TouchingTool& tool);

}  // namespace turgor
