// Spectrum of the force of a tool on a textured surface.
#pragma once

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "turgor/core/vec.hpp"

namespace turgor::contact {

/// Frequency of the largest part of a signal of ticks of a millisecond, in steps of 1 Hz.
inline int peak_of(const std::vector<Vec3d>& forces, Vec3d along) {
  int best = 0;
  double most = 0;
  for (int f = 1; f < 500; f++) {
    std::complex<double> sum;
    for (std::size_t i = 0; i < forces.size(); i++)
      sum += dot(forces[i], along) * std::polar(1.0, -2 * std::numbers::pi * f * 1e-3 * double(i));
    if (std::abs(sum) > most) most = std::abs(sum), best = f;
  }
  return best;
}

/// Largest force [N].
inline double largest_of(const std::vector<Vec3d>& forces) {
  double most = 0;
  for (const Vec3d f : forces) most = std::max(most, norm(f));
  return most;
}

}  // namespace turgor::contact
