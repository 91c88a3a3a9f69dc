// Problems of FEBio's test suite (measured_febio.hpp) with a uniform deformation, so that a law at a point
// solves them: a body slides on three planes and stretches along one axis. The stretch across is the one of
// least energy.
#include <cmath>

#include "app/measured_febio.hpp"

namespace turgor {

namespace {

using lattice::LawModuli, lattice::SolidEnergy;

double energy_at(SolidEnergy energy, const LawModuli& moduli, double along, double across) {
  return law_energy(energy, {{Vec3d{along, 0, 0}, Vec3d{0, across, 0}, Vec3d{0, 0, across}}}, moduli);
}

/// Stretch across that is free of stress at a stretch along.
double free_across(SolidEnergy energy, const LawModuli& moduli, double along) {
  constexpr double kStep = 1e-4;
  constexpr int kIterations = 20;
  double across = 1 / std::sqrt(along);
  for (int n = 0; n < kIterations; n++) {
    const double up = energy_at(energy, moduli, along, across + kStep),
                 down = energy_at(energy, moduli, along, across - kStep);
    across -= kStep / 2 * (up - down) / (up - 2 * energy_at(energy, moduli, along, across) + down);
  }
  return across;
}

/// Norm of a bar of 2 × 1 × 1 that stretches to 1.25, at the 11 × 6 × 6 nodes of a mesh whose layers grow by
/// 1.2 along the bar.
double graded_bar_norm(SolidEnergy energy, const LawModuli& moduli) {
  constexpr double kStretch = 1.25, kLength = 2, kSide = 1, kGrowth = 1.2;
  constexpr int kLayers = 10, kAcross = 5;
  const double across = free_across(energy, moduli, kStretch);
  // nodes between the ends move along; all nodes off the planes move across, along y and along z
  double sum = 0, position = 0, layer = kLength * (kGrowth - 1) / (std::pow(kGrowth, kLayers) - 1);
  for (int n = 1; n < kLayers; n++, layer *= kGrowth) {
    position += layer;
    sum += std::pow((kStretch - 1) * position, 2) * (kAcross + 1) * (kAcross + 1);
  }
  for (int n = 1; n <= kAcross; n++)
    sum += 2 * std::pow((across - 1) * kSide * n / kAcross, 2) * (kAcross + 1) * (kLayers + 1);
  return std::sqrt(sum);
}

/// Norm of a unit cube of `layers` elements a side that stretches to 2. `counted` nodes of the pulled end
/// count as free.
double pulled_cube_norm(double poisson, int layers, int counted) {
  constexpr double kStretch = 2;
  const double across = free_across(SolidEnergy::kNeoHookean, febio_neo_hookean(poisson), kStretch);
  const int nodes = (layers + 1) * (layers + 1);
  double sum = counted * (kStretch - 1) * (kStretch - 1);
  for (int n = 1; n <= layers; n++) {
    const double share = double(n) / layers;
    if (n < layers) sum += nodes * std::pow((kStretch - 1) * share, 2);
    sum += 2 * nodes * std::pow((across - 1) * share, 2);
  }
  return std::sqrt(sum);
}

/// Norm of a unit cube without Poisson's ratio whose end bears a nominal stress: four nodes move.
double loaded_cube_norm(double stress) {
  constexpr double kStep = 1e-4;
  constexpr int kIterations = 20;
  const LawModuli moduli = febio_neo_hookean(0);
  const auto least = [&](double along) {
    return energy_at(SolidEnergy::kNeoHookean, moduli, along,
                     free_across(SolidEnergy::kNeoHookean, moduli, along));
  };
  double along = 1;
  for (int n = 0; n < kIterations; n++) {
    const double up = least(along + kStep), down = least(along - kStep);
    along -= kStep * ((up - down) / 2 - stress * kStep) / (up - 2 * least(along) + down);
  }
  return 2 * (along - 1);
}

}  // namespace

void add_uniform_febio(MeasuredResult& result) {
  const auto add = [&](const char* name, double stored, double found) {
    result.rows.push_back(febio_row(name, stored, found));
  };
  // c1 of Mooney and Rivlin's law: µ = 2 c1
  add("mi27, exponential b = 0, graded bar stretched to 1.25", 4.17586115304,
      graded_bar_norm(SolidEnergy::kExponential, {2, 100, 0}));
  add("mi01, neo-Hookean, cube stretched to 2", 1.89722024459, pulled_cube_norm(0.45, 1, 3));
  add("mi04, neo-Hookean, the same across alone", 0.775172839024, pulled_cube_norm(0.45, 1, 0));
  add("mi25, neo-Hookean, eight cubes stretched to 2", 1.92028200836, pulled_cube_norm(0.4, 2, 0));
  // at t = 1, 100 times the time of its pair, the viscous cube is as soft as without the pair
  add("ma05, neo-Hookean, relaxed cube under a load", 0.004003999996, loaded_cube_norm(0.002));
}

}  // namespace turgor
