// Ends of drawn cuts. Cells open as a whole, so the lips of a cut would end in an edge. They are closed to a
// point, for drawing only.
#pragma once

#include <vector>

#include "turgor/models/lattice/surface/cut_ends.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::lattice::detail {

/// Moves displaced vertices `x` (lattice frame [m]) near the ends of all cuts. `step`: smallest spacing [m].
void close_ends(const BodySurface& surface, const CutEnds& ends, Real step, std::vector<Vec3>& x);

}  // namespace turgor::lattice::detail
