// The order in which unknowns are eliminated: nested dissection by place. A body is cut in two where few
// vertices hold the halves together; those are eliminated last, and the halves in the same way before.
// [George 1973]
#pragma once

#include <span>
#include <vector>

#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

/// Rows of K in the order of elimination; `x` is the place of each row's node [m].
std::vector<int> nested_dissection(const BlockMatrix& k, std::span<const Vec3d> x);

}  // namespace turgor::sfem
