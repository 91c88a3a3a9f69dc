// Expected discretization error of tool forces on finite elements, and how to reduce it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turgor/models/sfem/expected_error.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// Elements under a ball or a capsule at its deepest; empty for other shapes, other models and tools without
/// contact.
std::optional<sfem::TouchedElements> touched_elements(const World& world, const TouchingTool& tool);

/// A warning for every tool whose expected force error exceeds 10 %.
std::vector<std::string> force_error_warnings(const World& world);

}  // namespace turgor
