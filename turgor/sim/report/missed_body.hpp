// A tool that went by its body: how near it came, and where the body is.
#pragma once

#include <string>

#include "turgor/sim/world.hpp"

namespace turgor {

/// Empty when the tool touched, or did not move yet; else a sentence.
std::string off_the_body(const World& world, const TouchingTool& tool);

}  // namespace turgor
