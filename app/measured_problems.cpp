// Problems with closed forms, of the kind by which suites such as FEBio's test materials [Maas, Ellis,
// Ateshian, Weiss 2012]: laws of the lattice at a point under confined compression, torsion, and with fibers.
//
//   confined      P = W'(λ), F = diag(1, 1, λ)      exponential: W' = 2µ/3 exp(b (Ī₁ − 3)) (λ^(1/3) −
//   λ^(−5/3)) + κ (λ − 1)
//                 Ī₁ = λ^(−2/3) (2 + λ²)            Ogden: W' = 4µ/3α (λ^(2α/3 − 1) − λ^(−α/3 − 1)) + κ (λ −
//                 1)
//   torsion by τ  M = 2π ∫ W'(γ) r² dr, γ = τ r     [Rivlin 1949] exponential, B = b τ²: M = πµτ/B² (1 + (B
//   a² − 1) exp(B a²)) fibers        k1/2k2 (exp(k2 (I₄ − 1)²) − 1) [Gasser, Ogden, Holzapfel 2006]
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include <fmt/format.h>

#include "app/measured_table.hpp"
#include "turgor/models/lattice/mechanics/solid_laws.hpp"

namespace turgor {

namespace {

using lattice::LawModuli, lattice::SolidEnergy;

constexpr double kMu = 2e3;  // shear modulus [Pa]

double bulk_of(double poisson) { return 2 * kMu * (1 + poisson) / (3 * (1 - 2 * poisson)); }

/// Slope of an energy along a deformation.
double slope_of(const std::function<double(double)>& energy, double at) {
  constexpr double kStep = 1e-5;
  return (energy(at + kStep) - energy(at - kStep)) / (2 * kStep);
}

MeasuredRow closed_row(const std::string& name, const char* source, const char* unit, double expected,
                       double found) {
  return band_row(name, source, unit, expected, 0.01 * std::abs(expected), found);
}

void add_confined(MeasuredResult& result) {
  constexpr double kStretch = 0.85, kStiffening = 4, kAlpha = -9;
  const double s = kStretch, third = std::cbrt(s), invariant = (2 + s * s) / (third * third);
  for (const double poisson : {0.3, 0.45, 0.499}) {
    const double bulk = bulk_of(poisson), pressure = bulk * (s - 1);
    const double exponential =
        2 * kMu / 3 * std::exp(kStiffening * (invariant - 3)) * (third - std::pow(s, -5.0 / 3));
    const double ogden =
        4 * kMu / (3 * kAlpha) * (std::pow(s, 2 * kAlpha / 3 - 1) - std::pow(s, -kAlpha / 3 - 1));
    const auto add = [&](const char* law, SolidEnergy energy, double stiffening, double isochoric) {
      const auto at = [&](double stretch) {
        return law_energy(energy, {{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, stretch}}},
                          {kMu, bulk, stiffening});
      };
      result.rows.push_back(closed_row(
          fmt::format("{}, confined to {:.3g}, Poisson's ratio {}: nominal stress", law, s, poisson),
          "closed form", "Pa", isochoric + pressure, slope_of(at, s)));
    };
    add("exponential b = 4", SolidEnergy::kExponential, kStiffening, exponential);
    add("Ogden alpha = -9", SolidEnergy::kOgden, kAlpha, ogden);
  }
}

/// Torque of a cylinder of radius `a` that is twisted by `twist` per length: slope of its energy per length,
/// by Gauss-Legendre quadrature over rings.
double torque(const LawModuli& m, double a, double twist) {
  constexpr double kPoints[] = {0.1488743390, 0.4333953941, 0.6794095683, 0.8650633667, 0.9739065285};
  constexpr double kWeights[] = {0.2955242247, 0.2692667193, 0.2190863625, 0.1494513492, 0.0666713443};
  const auto energy = [&](double t) {
    double sum = 0;
    for (std::size_t i = 0; i < std::size(kPoints); i++)
      for (const double side : {-1.0, 1.0}) {
        const double r = 0.5 * a * (1 + side * kPoints[i]);
        const Mat3d sheared{{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{t * r, 0, 1}}};
        sum += 0.5 * a * kWeights[i] * 2 * std::numbers::pi * r *
               law_energy(SolidEnergy::kExponential, sheared, m);
      }
    return sum;
  };
  constexpr double kStep = 1e-3;
  return (energy(twist + kStep) - energy(twist - kStep)) / (2 * kStep);
}

void add_torsion(MeasuredResult& result) {
  constexpr double kRadius = 0.01, kTwist = 60;  // [m], [1/m]: a shear of 0.6 at the surface
  const double square = kRadius * kRadius, bulk = bulk_of(0.45);
  result.rows.push_back(closed_row("neo-Hookean cylinder, twisted by 60/m: torque", "Rivlin 1949", "N m",
                                   std::numbers::pi / 2 * kMu * kTwist * square * square,
                                   torque({kMu, bulk, 0}, kRadius, kTwist)));
  for (const double b : {2.0, 8.0}) {
    const double factor = b * kTwist * kTwist;
    const double expected = std::numbers::pi * kMu * kTwist / (factor * factor) *
                            (1 + (factor * square - 1) * std::exp(factor * square));
    result.rows.push_back(closed_row(fmt::format("exponential cylinder b = {}, twisted by 60/m: torque", b),
                                     "closed form", "N m", expected,
                                     torque({kMu, bulk, b}, kRadius, kTwist)));
  }
}

void add_fibers(MeasuredResult& result) {
  constexpr double kFiber = 3e3, kGrowth = 2, kStretch = 1.2, kSheared = 0.4;
  const double half = std::sqrt(0.5);
  // slope of the fibers' energy by their square stretch
  const auto by_square = [](double square) {
    return kFiber * (square - 1) * std::exp(kGrowth * (square - 1) * (square - 1));
  };
  const auto along = [&](double s) {
    return law_energy(SolidEnergy::kExponential,
                      {{Vec3d{s, 0, 0}, Vec3d{0, 1 / std::sqrt(s), 0}, Vec3d{0, 0, 1 / std::sqrt(s)}}},
                      {kMu, bulk_of(0.45), 0, kFiber, kGrowth, {1, 0, 0}});
  };
  const double s = kStretch;
  result.rows.push_back(closed_row("fibers along a stretch of 1.2: nominal stress", "closed form", "Pa",
                                   kMu * (s - 1 / (s * s)) + 2 * s * by_square(s * s), slope_of(along, s)));
  for (const double side : {1.0, -1.0}) {
    const auto sheared = [&](double gamma) {
      return law_energy(SolidEnergy::kExponential, {{Vec3d{1, 0, 0}, Vec3d{gamma, 1, 0}, Vec3d{0, 0, 1}}},
                        {kMu, bulk_of(0.45), 0, kFiber, kGrowth, {half, side * half, 0}});
    };
    // |F a|² = 1 ± γ + γ²/2; fibers that shorten bear nothing
    const double square = 1 + side * kSheared + kSheared * kSheared / 2;
    const double expected = kMu * kSheared + (square > 1 ? by_square(square) * (side + kSheared) : 0);
    result.rows.push_back(closed_row(
        fmt::format("fibers that a shear of 0.4 {}: shear stress", side > 0 ? "stretches" : "shortens"),
        "closed form", "Pa", expected, slope_of(sheared, kSheared)));
  }
}

}  // namespace

void add_point_problems(MeasuredResult& result) {
  add_confined(result);
  add_torsion(result);
  add_fibers(result);
}

}  // namespace turgor
