// Rows of `turgor validate surgery` for needles in lattices: closed forms, and the same needle in finite
// elements.
#pragma once

#include <vector>

#include "app/validation.hpp"

namespace turgor {

void add_lattice_needles(const Exec& exec, bool quick, std::vector<Figure>& figures);

}  // namespace turgor
