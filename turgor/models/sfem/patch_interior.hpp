// Elimination of the fine nodes below the touched surface. The patch is bisected recursively; functions that
// only one half contains are eliminated there, so that matrices stay small until the halves are united.
// [George 1973]
#pragma once

#include <optional>
#include <span>

#include "turgor/models/sfem/patch_assembly.hpp"

namespace turgor::sfem {

/// True when the fine nodes below the surface can be eliminated first, and there are some.
bool has_free_interior(const Model& model, const PatchUnknowns& unknowns);

/// K_L and K_LG of the touched local functions alone, after elimination of the others. What these bear is
/// subtracted from the coarse stiffness, and so is contained in `change`. None if rounding hides that the
/// matrix is positive definite.
std::optional<PatchMatrices<double>> without_interior(const Model& model, std::span<const int> elements,
                                                      const FineMesh& fine, const PatchUnknowns& unknowns,
                                                      bool with_change);

}  // namespace turgor::sfem
