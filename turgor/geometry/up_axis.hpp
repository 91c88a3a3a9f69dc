// Up axis of a file. Modeling programs often have y up; bodies have z up (to the patient's head).
#pragma once

#include <cstdint>
#include <vector>

#include "turgor/core/vec.hpp"

namespace turgor {

enum class UpAxis : std::uint8_t { kX, kY, kZ };

/// Rotates a position so that `up` becomes +z; the third axis stays. Zeros are positive.
template <class T>
Vec<T> turned_up(Vec<T> x, UpAxis up) {
  if (up == UpAxis::kX) return {0 - x.z, x.y, x.x};
  if (up == UpAxis::kY) return {x.x, 0 - x.z, x.y};
  return x;
}

template <class T>
void turn_up(std::vector<Vec<T>>& positions, UpAxis up) {
  for (Vec<T>& x : positions) x = turned_up(x, up);
}

}  // namespace turgor
