// Which axis of a file points up. Programs for drawing have y up, bodies here z (to the patient's head).
#pragma once

#include <cstdint>
#include <vector>

#include "turgor/core/vec.hpp"

namespace turgor {

enum class UpAxis : std::uint8_t { kX, kY, kZ };

/// A place turned so that `up` becomes +z; the third axis stays. Zero gets no sign.
template <class T>
Vec<T> turned_up(Vec<T> x, UpAxis up) {
  if (up == UpAxis::kX) return {0 - x.z, x.y, x.x};
  if (up == UpAxis::kY) return {x.x, 0 - x.z, x.y};
  return x;
}

template <class T>
void turn_up(std::vector<Vec<T>>& places, UpAxis up) {
  for (Vec<T>& x : places) x = turned_up(x, up);
}

}  // namespace turgor
