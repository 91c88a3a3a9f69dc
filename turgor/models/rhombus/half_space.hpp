// Forces of tools on an elastic half space: the reference to which tissues with a known modulus are fitted.
#pragma once

#include <cmath>
#include <vector>

#include "turgor/core/assert.hpp"
#include "turgor/models/rhombus/calibrate.hpp"

namespace turgor::rhombus {

/// Contact modulus E* = E/(1 − ν²) [Pa].
inline double contact_modulus(double young, double poisson) { return young / (1 - poisson * poisson); }

/// Force of a rigid ball pressed in without friction [N], with a the contact radius:
///
///     δ = a artanh(a/R),    F = E* ((R² + a²) artanh(a/R) − a R)
///
/// Exact for the sphere, where Hertz takes a paraboloid. [Sneddon 1965]
inline double sneddon_force(double contact_modulus, double radius, double depth) {
  if (!(depth > 0)) return 0;
  TURGOR_CHECK(contact_modulus > 0 && radius > 0, "tissue and ball have a modulus and a radius");
  double low = 0, high = 40;  // bounds of artanh(a/R), which increases with the depth
  for (int i = 0; i < 60; i++) {
    const double middle = 0.5 * (low + high);
    (middle * std::tanh(middle) * radius < depth ? low : high) = middle;
  }
  const double tanh_low = std::tanh(low);
  return contact_modulus * radius * radius * ((1 + tanh_low * tanh_low) * low - tanh_low);
}

/// Stiffness of a disc that is bonded to the surface and moved along its normal [N/m]. Valid without
/// friction, or with friction on incompressible tissue.
inline double disc_stiffness(double contact_modulus, double radius) { return 2 * contact_modulus * radius; }

/// Largest pull of a disc, in radii, with a strain of at most 30 % in the half space below it. The strain on
/// the axis is largest one radius deep, with d/(π R) for incompressible tissue.
constexpr double kPulledRadii = 0.3 * 3.14159265358979;

/// Reference curve for the chain of a homogeneous, incompressible tissue: a ball of this radius pressed in by
/// 1/20 to 2 radii (Sneddon), and a disc pulled by up to 30 % of strain.
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
