// What makes a body unfit for a static solution, said with the numbers of what is wrong.
#pragma once

#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

/// Error: arrays that do not fit each other, an element without volume, a material that is none, a body or a
/// part of it that the fixed vertices do not hold.
Status check_body(const Body& body);

}  // namespace turgor::sfem
