#include "turgor/sim/student_quantile.hpp"

#include <cmath>
#include <numbers>

#include "turgor/core/assert.hpp"

namespace turgor {

namespace {

/// P(|T| < √ν tan θ).
///   ν even   sin θ (1 + 1/2 cos² θ + (1·3)/(2·4) cos⁴ θ + … to cos^(ν−2) θ)
///   ν odd    2/π (θ + sin θ (cos θ + 2/3 cos³ θ + (2·4)/(3·5) cos⁵ θ + … to cos^(ν−2) θ))
double probability(int freedom, double angle) {
  const bool is_odd = freedom % 2 != 0;
  const double cosine = std::cos(angle);
  double term = is_odd ? cosine : 1, sum = 0;
  for (int power = is_odd ? 1 : 0; power <= freedom - 2; power += 2) {
    sum += term;
    term *= cosine * cosine * (power + 1) / (power + 2);
  }
  const double share = std::sin(angle) * sum;
  return is_odd ? 2 / std::numbers::pi * (angle + share) : share;
}

}  // namespace

double student_quantile(int freedom) {
  TURGOR_ASSERT(freedom >= 1, "a residual has degrees of freedom");
  constexpr double kProbability = 0.95;
  constexpr int kMany = 200;
  // expansion around the normal distribution
  if (freedom >= kMany) {
    const double z = 1.959963984540054, z3 = z * z * z, z5 = z3 * z * z, n = freedom;
    return z + (z3 + z) / (4 * n) + (5 * z5 + 16 * z3 + 3 * z) / (96 * n * n);
  }
  // bisection of the angle
  double low = 0, high = std::numbers::pi / 2;
  for (int i = 0; i < 60; i++) {
    const double middle = (low + high) / 2;
    (probability(freedom, middle) < kProbability ? low : high) = middle;
  }
  return std::sqrt(double(freedom)) * std::tan((low + high) / 2);
}

}  // namespace turgor
