// What tools feel of an elastic half space: the reference that tissues with a modulus are fitted to.
#pragma once

#include <cmath>
#include <vector>

#include "turgor/models/rhombus/calibrate.hpp"

namespace turgor::rhombus {

/// E/(1 − ν²) [Pa].
inline double contact_modulus(double young, double poisson) { return young / (1 - poisson * poisson); }

/// A rigid ball pressed in without friction [N]. Exact for the sphere, where Hertz takes a paraboloid:
/// δ = a artanh(a/R), F = E* ((R² + a²) artanh(a/R) − a R), a the contact's radius. [Sneddon 1965]
inline double sneddon_force(double contact_modulus, double radius, double depth) {
  if (!(depth > 0)) return 0;
  double low = 0, high = 40;  // of artanh(a/R), which rises with the depth
  for (int i = 0; i < 60; i++) {
    const double middle = 0.5 * (low + high);
    (middle * std::tanh(middle) * radius < depth ? low : high) = middle;
  }
  const double part = std::tanh(low);
  return contact_modulus * radius * radius * ((1 + part * part) * low - part);
}

/// A disc that holds the surface and is moved along its normal [N/m]; without friction or with, when the
/// tissue is incompressible.
inline double disc_stiffness(double contact_modulus, double radius) { return 2 * contact_modulus * radius; }

/// Pulled by so many radii, a disc stretches the half space below it by 30 % at most: on the axis the strain
/// is largest a radius deep, d/(π R) there when the tissue is incompressible.
constexpr double kPulledRadii = 0.3 * 3.14159265358979;

/// A ball of this radius pressed in by 1/20 to 2 radii (Sneddon), and pulled by up to 30 % of strain (disc):
/// what a chain of a homogeneous, incompressible tissue is fitted to.
inline std::vector<CurvePoint> half_space_curve(double young, double radius) {
  const double modulus = contact_modulus(young, 0.5);
  std::vector<CurvePoint> curve;
  for (int i = 0; i <= 24; i++) {
    const double depth = radius * 0.05 * std::pow(40.0, i / 24.0);
    curve.push_back({depth, sneddon_force(modulus, radius, depth)});
  }
  for (int i = 1; i <= 15; i++) {
    const double pull = kPulledRadii * radius * i / 15;
    curve.push_back({-pull, -disc_stiffness(modulus, radius) * pull});
  }
  return curve;
}

}  // namespace turgor::rhombus
