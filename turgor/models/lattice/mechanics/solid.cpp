#include "turgor/models/lattice/mechanics/solid.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"

namespace turgor::lattice {

namespace {

struct Moduli {
  double shear, bulk;  // µ' and λ' over E [1]
};
Moduli moduli(double poisson) {
  const double mu = 0.5 / (1 + poisson), lambda = poisson / ((1 + poisson) * (1 - 2 * poisson));
  return {4.0 / 3 * mu, lambda + 5.0 / 6 * mu};
}

/// Hourglass modulus κ/E. A twisted bar of cells lacks the energy G θ² h²/6 at the centers, for two modes
/// with q = θ h²/4. A bent bar lacks more, since E replaces G. In a bar of n cells, this matters only by
/// 1/n².
double hourglass_modulus(Vec3d spacing, double poisson) { return 2 / (1 + poisson) / dot(spacing, spacing); }

}  // namespace

SolidLaw solid_law(Vec3 spacing, double poisson) {
  TURGOR_CHECK(poisson >= 0 && poisson < 0.5, "Poisson's ratio is from 0 to below 0.5");
  const Moduli m = moduli(poisson);
  const double volume = double(spacing.x) * spacing.y * spacing.z;
  return {.slope = {Real(0.25) / spacing.x, Real(0.25) / spacing.y, Real(0.25) / spacing.z},
          .shear = Real(volume * m.shear),
          .bulk = Real(volume * m.bulk),
          .hourglass = Real(volume * hourglass_modulus(Vec3d(spacing), poisson) / 8)};
}

CellCenter packed_center(Vec3d at) {
  std::uint32_t bits = 0;
  for (int axis = 0; axis < 3; axis++) {
    const auto steps = int(std::lround(std::clamp(at[axis], -1.0, 1.0) * 512));
    bits |= (std::uint32_t(std::clamp(steps, -512, 511)) & 1023u) << (10 * axis);
  }
  return {bits};
}

CellDeformation cell_deformation(const Vec3d (&u)[kCellCorners], Vec3 spacing, Vec3d point) {
  const Vec3d h(spacing);
  // deformation gradient and mean displacement
  Mat3d f;
  Vec3d mean;
  for (int n = 0; n < kCellCorners; n++) {
    const Vec3d side(corner_sign(n));
    mean += u[n] / 8;
    for (int axis = 0; axis < 3; axis++) f.column[axis] += u[n] * (side[axis] / (4 * h[axis]));
  }
  // hourglass displacements
  double hourglass = 0;
  for (int n = 0; n < kCellCorners; n++) {
    const Vec3d side(corner_sign(n)), corner_position = hadamard(side, h) * 0.5;
    const Vec3d hourglass_displacement = u[n] + corner_position - mean - f * corner_position;
    hourglass += dot(hourglass_displacement, hourglass_displacement);
  }
  // deformation gradient at the center of the filled part
  if (norm(point) > 0) {
    f = Mat3d{};
    for (int n = 0; n < kCellCorners; n++) {
      const Vec3d side(corner_sign(n)), factor = Vec3d{1, 1, 1} + hadamard(side, point);
      f.column[0] += u[n] * (side.x / (4 * h.x) * factor.y * factor.z);
      f.column[1] += u[n] * (side.y / (4 * h.y) * factor.z * factor.x);
      f.column[2] += u[n] * (side.z / (4 * h.z) * factor.x * factor.y);
    }
  }
  return {f, hourglass};
}

double cell_energy(const Vec3d (&u)[kCellCorners], Vec3 spacing, double poisson, Vec3d point) {
  const Moduli m = moduli(poisson);
  const Vec3d h(spacing);
  const auto [f, hourglass] = cell_deformation(u, spacing, point);
  // Neo-Hookean energy at this point
  const auto& [x, y, z] = f.column;
  const double square = dot(x, x) + dot(y, y) + dot(z, z), growth = dot(x, cross(y, z));
  const double rest = 1 + 0.75 * m.shear / m.bulk;  // α: offset of J such that F = I is at rest
  const auto middle = [&](double i, double j) {
    return 0.5 * (m.shear * (i - 3 - std::log(i + 1)) + m.bulk * (j - rest) * (j - rest));
  };
  const double volume = h.x * h.y * h.z;
  return volume * (middle(square, growth) - middle(3, 1) + hourglass_modulus(h, poisson) * hourglass / 16);
}

}  // namespace turgor::lattice
