// Ends of drawn cuts. Cells open as a whole, so the lips of a cut would end in an edge. They are closed to a
// point, for drawing only.
#pragma once

#include <vector>

#include "turgor/models/lattice/surface/surface.hpp"
#include "turgor/models/lattice/surface/surface_plan.hpp"

namespace turgor::lattice::detail {

/// Moves displaced vertices `x` (lattice frame [m]) near both ends of every cut. `step`: smallest spacing
/// [m].
void close_ends(const BodySurface& surface, const SurfacePlan& plan, Real step, std::vector<Vec3>& x);

}  // namespace turgor::lattice::detail
