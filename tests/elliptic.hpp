// Elliptic integrals, for the periods of large motions.
#pragma once

#include <cmath>
#include <numbers>

namespace turgor::test {

/// Complete elliptic integral of the first kind with the parameter m, by the arithmetic-geometric mean.
inline double elliptic_k(double m) {
  double a = 1, b = std::sqrt(1 - m);
  for (int n = 0; n < 60; n++) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b), a = mean;
  }
  return std::numbers::pi / (2 * a);
}

}  // namespace turgor::test
