// Orientations as quaternions w, x, y, z, for files and devices. The engine itself uses axes (Mat3d).
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "turgor/core/vec.hpp"

namespace turgor {

using Quaternion = std::array<double, 4>;  // w, x, y, z

inline double dot(const Quaternion& a, const Quaternion& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

/// Unit quaternion; the argument must not be zero.
inline Quaternion normalized(Quaternion q) {
  const double length = std::sqrt(dot(q, q));
  for (double& component : q) component /= length;
  return q;
}

/// Interpolates between two orientations along the shorter arc: `a` at 0, `b` at 1.
inline Quaternion between(const Quaternion& a, const Quaternion& b, double s) {
  const double sign = dot(a, b) < 0 ? -1 : 1;
  Quaternion q;
  for (std::size_t i = 0; i < 4; i++) q[i] = (1 - s) * a[i] + s * sign * b[i];
  return dot(q, q) > 0 ? normalized(q) : a;
}

/// Rotation matrix of a unit quaternion; columns are the rotated x, y and z axes.
inline Mat3d axes_of(const Quaternion& q) {
  const auto [w, x, y, z] = q;
  return {{{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
           {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
           {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}}};
}

}  // namespace turgor
