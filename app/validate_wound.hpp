// Experiments of `turgor validate lattice` on wounds and touches.
#pragma once

#include "app/validation.hpp"

namespace turgor {

/// Adds gapes over the lattice spacing, the frame rate and the sweeps, at rest and in motion.
void add_wounds(const Exec& exec, bool quick, std::vector<Figure>& figures);
/// Adds a ball on layers of solid tissue.
void add_layers(const Exec& exec, bool quick, std::vector<Figure>& figures);

}  // namespace turgor
