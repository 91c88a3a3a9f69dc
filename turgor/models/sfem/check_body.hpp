// Checks a body for the defects that exclude a static solution. The messages contain the numbers of the
// affected elements and vertices.
#pragma once

#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

/// Error: arrays of inconsistent sizes, an element without volume or listed twice, an invalid material, a
/// body or a connected component that the fixed vertices do not hold, unless it may be loose.
Status check_body(const Body& body, bool may_be_loose = false);

}  // namespace turgor::sfem
