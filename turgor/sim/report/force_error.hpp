// Expected discretization error of tool forces on finite elements and lattices, and how to reduce it.
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

/// Expected relative error of the force of a ball or a capsule on a lattice with this spacing [m], for a
/// contact radius √(tool radius · depth) [m]. Fitted to presses on, beside and between nodes
/// (docs/validation-lattice.md).
double lattice_force_error(double spacing, double contact);

/// Expected relative error of the force at its deepest; empty where it is not known, as in touched_elements,
/// and for chains.
std::optional<double> expected_force_error(const World& world, const TouchingTool& tool);

/// A warning for every tool whose expected force error exceeds 10 % on elements, 20 % on a lattice.
std::vector<std::string> force_error_warnings(const World& world);

}  // namespace turgor
