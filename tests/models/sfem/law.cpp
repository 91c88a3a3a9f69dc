// The law of a nonlinear patch against finite differences and closed forms.
#include "turgor/models/sfem/law.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace turgor::sfem {
namespace {

constexpr Mat3d kDeformed{{{1.21, 0.13, -0.07}, {-0.18, 0.92, 0.05}, {0.11, -0.09, 1.08}}};
constexpr Moduli kModuli{2.3e4, 3.1e3};

double& entry(Mat3d& f, std::size_t k) { return f.column[k / 3][int(k % 3)]; }

// Stress and tangent are the derivatives of energy and stress, for a neo-Hookean and a stiff law.
TEST(SfemLaw, DerivativesMatchFiniteDifferences) {
  constexpr double kStep = 1e-5;
  for (const double b : {0.0, 3.7}) {
    const Law law{b};
    const LawStress found = law_stress(kDeformed, kModuli, law);
    for (std::size_t k = 0; k < 9; k++) {
      Mat3d more = kDeformed, less = kDeformed;
      entry(more, k) += kStep, entry(less, k) -= kStep;
      const double slope = (law_energy(more, kModuli, law) - law_energy(less, kModuli, law)) / (2 * kStep);
      EXPECT_NEAR(found.stress[k], slope, 1e-5 * kModuli.shear) << b << " " << k;
      const LawStress up = law_stress(more, kModuli, law), down = law_stress(less, kModuli, law);
      for (std::size_t row = 0; row < 9; row++)
        EXPECT_NEAR(found.tangent[9 * row + k], (up.stress[row] - down.stress[row]) / (2 * kStep),
                    1e-4 * kModuli.bulk)
            << b << " " << row << " " << k;
    }
  }
}

// At rest the tangent is that of linear elasticity: λ δ δ + µ (δ δ + δ δ).
TEST(SfemLaw, SmallStrainSeesLinearModuli) {
  const LawStress rest = law_stress(Mat3d{}, kModuli, {8});
  const double lambda = kModuli.bulk - 2.0 / 3 * kModuli.shear;
  for (std::size_t a = 0; a < 9; a++) {
    EXPECT_NEAR(rest.stress[a], 0, 1e-9 * kModuli.bulk);
    for (std::size_t b = 0; b < 9; b++) {
      const std::size_t i = a % 3, j = a / 3, k = b % 3, l = b / 3;
      const double linear =
          lambda * (i == j && k == l) + kModuli.shear * ((i == k && j == l) + (i == l && j == k));
      EXPECT_NEAR(rest.tangent[9 * a + b], linear, 1e-9 * kModuli.bulk);
    }
  }
}

// Simple shear by γ keeps the volume: P12 = µ γ exp(b γ²).
TEST(SfemLaw, SimpleShearMatchesClosedForm) {
  for (const double gamma : {0.1, 0.5, 0.9}) {
    const LawStress found = law_stress({{{1, 0, 0}, {gamma, 1, 0}, {0, 0, 1}}}, kModuli, {2.5});
    EXPECT_NEAR(found.stress[3], kModuli.shear * gamma * std::exp(2.5 * gamma * gamma), 1e-9 * kModuli.bulk);
  }
}

// Nearly inverted elements have no finite energy, so that a line search avoids them.
TEST(SfemLaw, InvertedElementHasInfiniteEnergy) {
  EXPECT_FALSE(std::isfinite(law_energy({{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, kModuli, {})));
  EXPECT_FALSE(std::isfinite(law_energy({{{9, 0, 0}, {0, 9, 0}, {0, 0, 0.0124}}}, kModuli, {5})));
}

}  // namespace
}  // namespace turgor::sfem
