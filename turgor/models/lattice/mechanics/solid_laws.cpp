#include "turgor/models/lattice/mechanics/solid_laws.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "turgor/core/assert.hpp"

namespace turgor::lattice {

namespace {

/// Eigenvalues of Fᵀ F, by the trigonometric formula [Smith 1961].
std::array<double, 3> eigenvalues_of_gram(const Mat3d& f) {
  const auto& [x, y, z] = f.column;
  const double xx = dot(x, x), yy = dot(y, y), zz = dot(z, z), xy = dot(x, y), xz = dot(x, z), yz = dot(y, z);
  const double mean = (xx + yy + zz) / 3, a = xx - mean, b = yy - mean, c = zz - mean;
  const double spread = std::sqrt((a * a + b * b + c * c + 2 * (xy * xy + xz * xz + yz * yz)) / 6);
  if (spread == 0) return {mean, mean, mean};
  const double determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz);
  const double angle = std::acos(std::clamp(determinant / (2 * spread * spread * spread), -1.0, 1.0)) / 3;
  const double most = mean + 2 * spread * std::cos(angle),
               least = mean + 2 * spread * std::cos(angle + 2 * std::numbers::pi / 3);
  return {most, 3 * mean - most - least, least};
}

/// Isochoric energy µ/2b (exp(x) − 1) with x = b (Ī₁ − 3), linear beyond the largest exponent.
double exponential_energy(double stiffening, double isochoric) {
  const double x = stiffening * isochoric, most = double(kLargestExponent);
  if (stiffening == 0) return isochoric / 2;
  if (x <= most) return std::expm1(x) / (2 * stiffening);
  return (std::exp(most) * (1 + x - most) - 1) / (2 * stiffening);
}

/// Σ 2/α² (λ̄ᵢ^α − 1), linear in ln λ̄ᵢ beyond the largest exponent, with the eigenvalues of Fᵀ F.
double ogden_energy(double alpha, const Mat3d& f, double volume) {
  const double most = double(kLargestExponent), third = std::log(volume) / 3;
  double sum = 0;
  for (const double square : eigenvalues_of_gram(f)) {
    const double x = alpha * (0.5 * std::log(std::max(square, 1e-4)) - third);
    sum += x <= most ? std::expm1(x) : std::exp(most) * (1 + x - most) - 1;
  }
  return 2 * sum / (alpha * alpha);
}

/// k1/2k2 (exp(k2 ⟨Ī₄ − 1⟩²) − 1), linear in the square beyond the largest exponent.
double fiber_energy(const Mat3d& f, double volume, const LawModuli& m) {
  if (m.fiber == 0) return 0;
  const Vec3d fa = f * m.direction;
  const double e = std::max(0.0, std::pow(volume, -2.0 / 3) * dot(fa, fa) - 1), square = e * e;
  const double y = m.fiber_stiffening * square, most = double(kLargestExponent);
  if (m.fiber_stiffening == 0) return 0.5 * m.fiber * square;
  return 0.5 * m.fiber / m.fiber_stiffening *
         (y < most ? std::expm1(y) : std::exp(most) * (1 + y - most) - 1);
}

}  // namespace

int most_pairs(const TissueParams& tissue) {
  int most = pair_count(tissue.prony);
  for (const TissueLayer& layer : tissue.layers)
    if (layer.prony) most = std::max(most, pair_count(*layer.prony));
  return most;
}

bool has_fibers(const TissueParams& tissue) {
  const auto has = [](const TissueLayer& layer) { return layer.fiber.stiffness > 0; };
  return tissue.fiber.stiffness > 0 || std::any_of(tissue.layers.begin(), tissue.layers.end(), has);
}

double largest_poisson(const TissueParams& tissue) {
  double most = tissue.poisson;
  for (const TissueLayer& layer : tissue.layers)
    most = std::max(most, layer.slide < 1 ? std::max(layer.poisson, 0.499) : layer.poisson);
  return most;
}

bool has_mixed_laws(const TissueParams& tissue) {
  const auto differs = [&](const TissueLayer& layer) { return energy_of(layer, tissue) != tissue.energy; };
  return std::any_of(tissue.layers.begin(), tissue.layers.end(), differs);
}

LawRatios law_ratios(SolidEnergy energy, double poisson) {
  TURGOR_CHECK(poisson >= 0 && poisson < 0.5, "Poisson's ratio is from 0 to below 0.5");
  const double mu = 0.5 / (1 + poisson), lambda = poisson / ((1 + poisson) * (1 - 2 * poisson));
  if (energy == SolidEnergy::kNeoHookean) return {4.0 / 3 * mu, lambda + 5.0 / 6 * mu};
  return {mu, lambda + 2.0 / 3 * mu};
}

double hourglass_over_shear(SolidEnergy energy) { return energy == SolidEnergy::kNeoHookean ? 3 : 4; }

double law_energy(SolidEnergy energy, const Mat3d& f, const LawModuli& m) {
  const auto& [x, y, z] = f.column;
  const double square = dot(x, x) + dot(y, y) + dot(z, z), j = dot(x, cross(y, z));
  if (energy == SolidEnergy::kNeoHookean) {
    const double rest = 1 + 0.75 * m.shear / m.bulk;
    const auto at = [&](double i, double volume) {
      return 0.5 * (m.shear * (i - 3 - std::log(i + 1)) + m.bulk * (volume - rest) * (volume - rest));
    };
    return at(square, j) - at(3, 1);
  }
  const double least = double(kLeastGrowth), bounded = std::max(j, least), lack = bounded - j;
  const double volume = 0.5 * m.bulk * (j - 1) * (j - 1);
  if (energy == SolidEnergy::kOgden) return m.shear * ogden_energy(m.stiffening, f, bounded) + volume;
  const double r = std::pow(bounded, -2.0 / 3) * (1 + 2.0 / 3 * lack / bounded);
  return m.shear * exponential_energy(m.stiffening, r * square - 3) + volume + fiber_energy(f, bounded, m);
}

}  // namespace turgor::lattice
