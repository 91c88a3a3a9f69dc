// Warning about a tool that missed its body, with the smallest distance.
#pragma once

#include <string>

#include "turgor/sim/world.hpp"

namespace turgor {

/// A sentence; empty if the tool touched the body or has no ticks.
std::string missed_body_note(const World& world, const TouchingTool& tool);

}  // namespace turgor
