#include "turgor/models/lattice/mechanics/skin_calibration.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"

namespace turgor::lattice {

namespace {

/// Derivatives of the energy parts: of the matrix by Ī, of the fibers by E [N/m].
struct SkinSlopes {
  double matrix, matrix_slope, fiber, fiber_slope;
};
SkinSlopes skin_slopes(const SkinParams& skin, double invariant, double strain) {
  const double most = double(kLargestSkinExponent);
  SkinSlopes s{};
  const double x = skin.stiffening * invariant;
  s.matrix = 0.5 * skin.shear * std::exp(std::min(x, most));
  s.matrix_slope = x < most ? skin.stiffening * s.matrix : 0;
  if (!(strain > 0)) return s;
  const double y = skin.fiber_stiffening * strain * strain,
               stiff = skin.fiber_stiffness * std::exp(std::min(y, most));
  s.fiber = stiff * strain, s.fiber_slope = stiff * (y < most ? 1 + 2 * y : 1);
  return s;
}

/// (exp(x) − 1)/k for x = k y, linear in x beyond the largest exponent; y for k = 0.
double bounded_expm1(double k, double y) {
  const double x = k * y, most = double(kLargestSkinExponent);
  if (k == 0) return y;
  return (x < most ? std::expm1(x) : std::exp(most) * (1 + x - most) - 1) / k;
}

/// Change of the tensions by the logarithms of the stretches, and the tensions.
struct TensionSlopes {
  double along, across;
  double by[2][2];
};
TensionSlopes tension_slopes(const SkinParams& skin, SkinStretch at) {
  constexpr double kStep = 1e-6;
  const SkinTangent now = skin_tangent(skin, at);
  TensionSlopes s{now.tension_along, now.tension_across, {}};
  const SkinTangent a = skin_tangent(skin, {at.along * (1 + kStep), at.across}),
                    b = skin_tangent(skin, {at.along, at.across * (1 + kStep)});
  s.by[0][0] = (a.tension_along - s.along) / kStep, s.by[1][0] = (a.tension_across - s.across) / kStep;
  s.by[0][1] = (b.tension_along - s.along) / kStep, s.by[1][1] = (b.tension_across - s.across) / kStep;
  return s;
}

}  // namespace

/// With C₁₂ = 0, in invariants Ī = C₁₁ + C₂₂ + 1/(C₁₁ C₂₂) and E:
///   T₁ = 2 λ₁/λ₂ W₁      tangent: 4 λ₁⁴ W₁₁/J, 4 λ₁² λ₂² W₁₂/J, λ₁² λ₂² ∂²W/∂C₁₂²/J      J = λ₁ λ₂
SkinTangent skin_tangent(const SkinParams& skin, SkinStretch stretch) {
  const double a = stretch.along * stretch.along, c = stretch.across * stretch.across, d = a * c;
  const double kappa = skin.dispersion, share = 1 - 3 * kappa, j = stretch.along * stretch.across;
  TURGOR_CHECK(a > 0 && c > 0, "skin has an area");
  // derivatives of Ī
  const double invariant = a + c + 1 / d - 3, i1 = 1 - 1 / (a * d), i2 = 1 - 1 / (c * d);
  const double i11 = 2 / (a * a * d), i22 = 2 / (c * c * d), i12 = 1 / (d * d);
  const double e1 = kappa * i1 + share, e2 = kappa * i2;
  // derivatives of W by C₁₁ and C₂₂
  const SkinSlopes w = skin_slopes(skin, invariant, kappa * invariant + share * (a - 1));
  const double both = w.matrix + kappa * w.fiber;
  const double w1 = both * i1 + share * w.fiber, w2 = both * i2;
  const double w11 = w.matrix_slope * i1 * i1 + w.fiber_slope * e1 * e1 + both * i11,
               w22 = w.matrix_slope * i2 * i2 + w.fiber_slope * e2 * e2 + both * i22,
               w12 = w.matrix_slope * i1 * i2 + w.fiber_slope * e1 * e2 + both * i12;
  return {.tension_along = 2 * a / j * w1,
          .tension_across = 2 * c / j * w2,
          .along = 4 * a * a / j * w11,
          .across = 4 * c * c / j * w22,
          .coupling = 4 * a * c / j * w12,
          .shear = a * c / j * 2 * both / (d * d)};
}

double exponential_skin_energy(const SkinParams& skin, Vec3d f, Vec3d g) {
  const double a = dot(f, f), c = dot(g, g), b = dot(f, g), d = a * c - b * b;
  const double least = double(kLeastSkinDeterminant), bounded = std::max(d, least);
  const double invariant = a + c + (1 + (bounded - d) / bounded) / bounded - 3;
  const double strain = std::max(0.0, skin.dispersion * invariant + (1 - 3 * skin.dispersion) * (a - 1));
  return 0.5 * (skin.shear * bounded_expm1(skin.stiffening, invariant) +
                skin.fiber_stiffness * bounded_expm1(skin.fiber_stiffening, strain * strain));
}

std::optional<SkinStretch> stretch_of_tension(const SkinParams& skin) {
  constexpr int kMostSteps = 200;
  constexpr double kLongestStep = 0.02, kTolerance = 1e-9, kLargestStretch = 4;
  const double scale = std::max({skin.tension_along, skin.tension_across, 1e-3 * skin.shear});
  SkinStretch at;
  for (int n = 0; n < kMostSteps; n++) {
    const TensionSlopes s = tension_slopes(skin, at);
    const double lack[2] = {skin.tension_along - s.along, skin.tension_across - s.across};
    if (std::max(std::abs(lack[0]), std::abs(lack[1])) <= kTolerance * scale) return at;
    // Newton step in the logarithms; short, since the exponential would overshoot
    const double det = s.by[0][0] * s.by[1][1] - s.by[0][1] * s.by[1][0];
    double step[2] = {(s.by[1][1] * lack[0] - s.by[0][1] * lack[1]) / det,
                      (s.by[0][0] * lack[1] - s.by[1][0] * lack[0]) / det};
    const double most = std::max(std::abs(step[0]), std::abs(step[1]));
    if (!std::isfinite(most)) return {};
    for (double& length : step) length *= most > kLongestStep ? kLongestStep / most : 1;
    at.along *= 1 + step[0], at.across *= 1 + step[1];
    if (at.along > kLargestStretch || at.across > kLargestStretch) return {};
  }
  return {};
}

ExponentialSkin exponential_skin(const SkinParams& skin) {
  if (skin.law != SkinLaw::kExponential) return {};
  const SkinStretch at = stretch_of_tension(skin).value_or(SkinStretch{});
  return {.shear = Real(skin.shear),
          .stiffening = Real(skin.stiffening),
          .fiber = Real(skin.fiber_stiffness),
          .fiber_stiffening = Real(skin.fiber_stiffening),
          .dispersion = Real(skin.dispersion),
          .along = Real(at.along),
          .across = Real(at.across),
          .rest_share = Real(1 / (at.along * at.across))};
}

double skin_stiffness(const SkinParams& skin) {
  if (skin.law != SkinLaw::kExponential) return skin.stiffness;
  const double share = 1 - 3 * skin.dispersion;
  return 4 * (skin.shear + share * share * skin.fiber_stiffness);
}

}  // namespace turgor::lattice
