// Limit of the positions that files may hold.
#pragma once

#include <cmath>

#include "turgor/core/vec.hpp"

namespace turgor::io {

/// True if a position is finite and its coordinates are below 1e9 m.
inline bool is_valid_position(Vec3d x) {
  constexpr double kFarthest = 1e9;  // [m]
  return std::abs(x.x) < kFarthest && std::abs(x.y) < kFarthest && std::abs(x.z) < kFarthest;
}

}  // namespace turgor::io
