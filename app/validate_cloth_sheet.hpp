// Whether a sheet is the same cloth on any mesh.
#pragma once

#include <vector>

#include "app/validation.hpp"
#include "turgor/core/exec.hpp"

namespace turgor {

/// A strip that is pulled, along warp and weft, and one that hangs over an edge, in several kinds of triangles.
void add_sheet_figures(const Exec& exec, bool quick, std::vector<Figure>& figures);

}  // namespace turgor
