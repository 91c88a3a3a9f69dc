// The parts of `turgor validate lattice` that take a body with a wound, or one that is touched.
#pragma once

#include "app/validation.hpp"

namespace turgor {

/// Gapes by the lattice's step, the frame rate and the sweeps, at rest and on their way.
void add_wounds(const Exec& exec, bool quick, std::vector<Figure>& figures);
/// A ball on layers of solid tissue.
void add_layers(const Exec& exec, bool quick, std::vector<Figure>& figures);

}  // namespace turgor
