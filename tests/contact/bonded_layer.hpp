// Closed-form force of a ball on an elastic layer, the reference for contact forces.
#pragma once

#include <cmath>
#include <numbers>

namespace turgor::contact {

/// Force of a rigid frictionless ball pressed by `depth` into a layer bonded to its base, at small strains
/// [N]. [Dimitriadis, Horkay, Maresca, Kachar and Chadwick 2002, eq. 11 and 13]
inline double force_on_bonded_layer(double young, double poisson, double radius, double depth,
                                    double height) {
  const double v = poisson, pi = std::numbers::pi, x = std::sqrt(radius * depth) / height;
  const double a = -(1.2876 - 1.4678 * v + 1.3442 * v * v) / (1 - v);
  const double b = (0.6387 - 1.0277 * v + 1.5164 * v * v) / (1 - v);
  const double cube = a * a * a;
  const double factor = 1 - 2 * a / pi * x + 4 * a * a / (pi * pi) * x * x -
                        8 / std::pow(pi, 3) * (cube + 4 * pi * pi / 15 * b) * std::pow(x, 3) +
                        16 * a / std::pow(pi, 4) * (cube + 3 * pi * pi / 5 * b) * std::pow(x, 4);
  return 4.0 / 3 * young / (1 - v * v) * std::sqrt(radius) * std::pow(depth, 1.5) * factor;
}

}  // namespace turgor::contact
