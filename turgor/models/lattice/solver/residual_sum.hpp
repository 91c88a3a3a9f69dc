// Residual of a VBD step: the force at one node, and its norms over many nodes, for host and device.
#pragma once

#include <algorithm>
#include <cmath>

#include "turgor/core/vec.hpp"

namespace turgor::lattice {

/// Residual at a free node, r = f + (y − u)/(h² w), the negative gradient of the energy of the step [N].
/// `force`: elements and contacts [N]; `inertial_offset`: y − u [m]; `w`: inverse mass [1/kg].
TURGOR_HD inline Vec3d residual_force(Vec3 force, Vec3 inertial_offset, Real w, double dt) {
  return Vec3d(force) + Vec3d(inertial_offset) / (double(w) * dt * dt);
}

/// Residual of some nodes or virtual nodes.
struct ResidualSum {
  double largest2 = 0, sum2 = 0;  // |r|² [N²]

  TURGOR_HD void add(const ResidualSum& more) {
    largest2 = more.largest2 > largest2 ? more.largest2 : largest2;
    sum2 += more.sum2;
  }
  TURGOR_HD void add(Vec3d force) {
    const double squared = dot(force, force);
    add(ResidualSum{squared, squared});
  }
  double largest() const { return std::sqrt(largest2); }                        // [N]
  double rms(int nodes) const { return std::sqrt(sum2 / std::max(1, nodes)); }  // [N]
};

}  // namespace turgor::lattice
