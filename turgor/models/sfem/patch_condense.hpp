// A patch's coupled system, condensed to the points of its surface: S = K_L − K_LG Ξ K_GL is factored, and
// what moves the points is read from the end of the factor. [docs/models/sfem.md]
#pragma once

#include <span>

#include "turgor/models/sfem/patch.hpp"
#include "turgor/models/sfem/patch_assembly.hpp"

namespace turgor::sfem {

/// Makes Patch::compliance and Patch::system of a patch whose points are there. False: the numbers of T are
/// too few.
template <class T>
bool condense(const Model& model, std::span<const int> elements, const FineMesh& fine,
              const PatchUnknowns& unknowns, bool with_change, Patch& patch);

}  // namespace turgor::sfem
