// Condensation of a patch's coupled system to the points of its surface: S = K_L − K_LG Ξ K_GL is factored,
// and the points' compliance is read from the end of the factor. [docs/models/sfem.md]
#pragma once

#include <span>

#include "turgor/models/sfem/patch.hpp"
#include "turgor/models/sfem/patch_assembly.hpp"

namespace turgor::sfem {

/// Computes Patch::compliance and Patch::system of a patch with its points. False when the precision of T is
/// not sufficient.
template <class T>
bool condense(const Model& model, std::span<const int> elements, const FineMesh& fine,
              const PatchUnknowns& unknowns, bool with_change, Patch& patch);

}  // namespace turgor::sfem
