#include "turgor/models/lattice/mechanics/solid.hpp"

namespace turgor::lattice {

namespace {

struct Moduli {
  double shear, bulk;  // µ' and λ' over E [1]
};
Moduli moduli(double poisson) {
  const double mu = 0.5 / (1 + poisson), lambda = poisson / ((1 + poisson) * (1 - 2 * poisson));
  return {4.0 / 3 * mu, lambda + 5.0 / 6 * mu};
}

/// κ/E: what a twisted bar of cells lacks at their middles, G θ² h²/6 for two shapes of q = θ h²/4; a bent
/// one lacks more, E instead of G, of which a bar of n cells feels 1/n².
double hourglass_modulus(Vec3d step, double poisson) { return 2 / (1 + poisson) / dot(step, step); }

}  // namespace

SolidLaw solid_law(Vec3 step, double poisson) {
  const Moduli m = moduli(poisson);
  const double volume = double(step.x) * step.y * step.z;
  return {.slope = {Real(0.25) / step.x, Real(0.25) / step.y, Real(0.25) / step.z},
          .shear = Real(volume * m.shear),
          .bulk = Real(volume * m.bulk),
          .hourglass = Real(volume * hourglass_modulus(Vec3d(step), poisson) / 8)};
}

double cell_energy(const Vec3d (&u)[kCellCorners], Vec3 step, double poisson) {
  const Moduli m = moduli(poisson);
  const Vec3d h(step);
  Mat3d f;
  Vec3d mean;
  for (int n = 0; n < kCellCorners; n++) {
    const Vec3d side(corner_side(n));
    mean += u[n] / 8;
    for (int axis = 0; axis < 3; axis++) f.column[axis] += u[n] * (side[axis] / (4 * h[axis]));
  }
  double bent = 0;
  for (int n = 0; n < kCellCorners; n++) {
    const Vec3d side(corner_side(n)), place = hadamard(side, h) * 0.5;
    const Vec3d beyond = u[n] + place - mean - f * place;
    bent += dot(beyond, beyond);
  }
  const auto& [x, y, z] = f.column;
  const double square = dot(x, x) + dot(y, y) + dot(z, z), growth = dot(x, cross(y, z));
  const double rest = 1 + 0.75 * m.shear / m.bulk;  // α: where the volume term rests, so that F = 1 does
  const auto middle = [&](double i, double j) {
    return 0.5 * (m.shear * (i - 3 - std::log(i + 1)) + m.bulk * (j - rest) * (j - rest));
  };
  const double volume = h.x * h.y * h.z;
  return volume * (middle(square, growth) - middle(3, 1) + hourglass_modulus(h, poisson) * bent / 16);
}

}  // namespace turgor::lattice
