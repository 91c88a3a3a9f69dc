// Isotropic solid tissue: each cell of the lattice is one hexahedral element. Stable Neo-Hookean energy
// (Smith, de Goes, Kim 2018) at the center, plus an hourglass stiffness against the four modes with zero
// gradient at the center. All functions are pure; docs/models/lattice.md has the equations.
#pragma once

#include "turgor/models/lattice/mechanics/element_energies.hpp"

namespace turgor::lattice {

/// Side of a corner relative to the cell's center: -1 or 1 along each axis.
constexpr Int3 corner_sign(int n) { return cell_corner(n) * 2 - Int3{1, 1, 1}; }

/// Constants of a solid cell, per unit of Young's modulus. V: volume of the cell.
struct SolidLaw {
  Vec3 slope;      // derivative of a corner's shape function at the center, unsigned: 1/(4 spacing) [1/m]
  Real shear;      // V µ'/E [m³]
  Real bulk;       // V λ'/E [m³]
  Real hourglass;  // V κ/8E, against hourglass modes [m]
};
/// Uses Lamé's moduli µ and λ for a Poisson's ratio in [0, 0.5): µ' = 4/3 µ, λ' = λ + 5/6 µ.
SolidLaw solid_law(Vec3 spacing, double poisson);

/// Center of the filled part of a cell: its coordinates from the cell's center in half cells, each in [-1,
/// 1). Ten bits an axis; 0 is the center of the cell.
struct CellCenter {
  std::uint32_t bits = 0;

  static constexpr Real kUnit = Real(1) / 512;  // [half cells]
  TURGOR_HD Vec3 in_half_cells() const {
    return {Real(std::int32_t(bits << 22) >> 22) * kUnit, Real(std::int32_t(bits << 12) >> 22) * kUnit,
            Real(std::int32_t(bits << 2) >> 22) * kUnit};
  }
};
/// `at`: in half cells; coordinates outside of [-1, 1) become the nearest inside.
CellCenter packed_center(Vec3d at);

/// Eight times the mean displacement of the corners, and the differences of the far and near corners of each
/// axis [m].
struct CornerSums {
  Vec3 mean, x, y, z;
};
[[gnu::always_inline]] TURGOR_HD inline CornerSums corner_sums(const Vec3 (&d)[kCellCorners]) {
  const Vec3 sum0 = d[0] + d[1], sum1 = d[2] + d[3], sum2 = d[4] + d[5], sum3 = d[6] + d[7];
  const Vec3 low = sum0 + sum1, high = sum2 + sum3;
  return {low + high, (d[1] - d[0]) + (d[3] - d[2]) + ((d[5] - d[4]) + (d[7] - d[6])),
          (sum1 - sum0) + (sum3 - sum2), high - low};
}

/// Displacement gradient of a cell at its center, by columns, and the hourglass displacement of one corner.
struct CellGradient {
  Vec3 x, y, z;                 // du/dx, du/dy, du/dz [1]
  Vec3 hourglass_displacement;  // displacement of corner `at` beyond mean and gradient [m]
};

/// `d`: displacements of the corners relative to corner `at` [m].
[[gnu::always_inline]] TURGOR_HD inline CellGradient cell_gradient(const Vec3 (&d)[kCellCorners], int at,
                                                                   Vec3 slope) {
  const auto [mean, x, y, z] = corner_sums(d);
  const Int3 side = corner_sign(at);
  const Vec3 plane = mean + x * Real(side.x) + y * Real(side.y) + z * Real(side.z);
  return {x * slope.x, y * slope.y, z * slope.z, plane * Real(-0.125)};
}

/// Gradient of the shape function of a corner at a point of the cell, in half cells from the center [1/m].
[[gnu::always_inline]] TURGOR_HD inline Vec3 shape_gradient(int corner, Vec3 slope, Vec3 point) {
  const Int3 side = corner_sign(corner);
  const Real sx = Real(side.x), sy = Real(side.y), sz = Real(side.z);
  const Real fx = 1 + sx * point.x, fy = 1 + sy * point.y, fz = 1 + sz * point.z;
  return {sx * slope.x * fy * fz, sy * slope.y * fz * fx, sz * slope.z * fx * fy};
}

/// Differences of the corners that ∇u at the center does not contain, by pairs of axes and for all three [m].
struct CellTwists {
  Vec3 xy, xz, yz, xyz;
};
[[gnu::always_inline]] TURGOR_HD inline CellTwists cell_twists(const Vec3 (&d)[kCellCorners]) {
  const Vec3 low = (d[0] - d[1]) - (d[2] - d[3]), high = (d[4] - d[5]) - (d[6] - d[7]);
  return {low + high, (d[0] - d[1]) + (d[2] - d[3]) - ((d[4] - d[5]) + (d[6] - d[7])),
          (d[0] + d[1]) - (d[2] + d[3]) - ((d[4] + d[5]) - (d[6] + d[7])), high - low};
}

/// cell_gradient at a point, in half cells from the center; the hourglass displacement stays that of the
/// center.
[[gnu::always_inline]] TURGOR_HD inline CellGradient cell_gradient_at(const Vec3 (&d)[kCellCorners], int at,
                                                                      Vec3 slope, Vec3 point) {
  CellGradient u = cell_gradient(d, at, slope);
  const CellTwists t = cell_twists(d);
  u.x += (t.xy * point.y + t.xz * point.z + t.xyz * (point.y * point.z)) * slope.x;
  u.y += (t.xy * point.x + t.yz * point.z + t.xyz * (point.x * point.z)) * slope.y;
  u.z += (t.xz * point.x + t.yz * point.y + t.xyz * (point.x * point.y)) * slope.z;
  return u;
}

/// Adds a solid cell with E = `young` at a corner. F = I + ∇u, g: gradient of the corner's shape function at
/// the same point as ∇u. A cell that is filled in part has the filled fraction in `young`, and its point is
/// the center of the filled part (finite cell method with one point a cell [Parvizian et al. 2007]).
///   Ψ = ½ µ' (I_C − 3) + ½ λ' (J − α)² − ½ µ' ln(I_C + 1),  α = 1 + ¾ µ'/λ'      [Smith et al. 2018]
///   P = µ' (1 − 1/(I_C + 1)) F + λ' (J − α) cof F
///   f = −V P g − V κ/8 q      q: hourglass displacement
///   H = V (µ' (1 − 1/(I_C + 1)) |g|² I + 2 µ'/(I_C + 1)² (F g)(F g)ᵀ + λ' (cof F g)(cof F g)ᵀ) + V κ/16 I
/// H is exact for Ψ and positive definite, since J is linear in the position of one corner. P is evaluated as
/// µ' (s F + ¾ (F − cof F)) + λ' (J − 1) cof F with s = ¼ (I_C − 3)/(I_C + 1). This form has no cancellation
/// for small ∇u.
[[gnu::always_inline]] TURGOR_HD inline void add_cell(NodeSystem& s, const CellGradient& u, Vec3 g,
                                                      const SolidLaw& law, Real young) {
  // invariants of ∇u
  const Vec3 cx = cross(u.y, u.z), cy = cross(u.z, u.x), cz = cross(u.x, u.y);
  const Real trace = u.x.x + u.y.y + u.z.z;
  const Real stretch = 2 * trace + dot(u.x, u.x) + dot(u.y, u.y) + dot(u.z, u.z);  // I_C − 3
  const Real growth = trace + (cx.x + cy.y + cz.z) + dot(u.x, cx);                 // J − 1
  const Real inverse = 1 / (4 + stretch), beyond = Real(0.25) * stretch * inverse;

  // F g and cof(F) g
  const Vec3 du_g = u.x * g.x + u.y * g.y + u.z * g.z;  // (F − I) g
  const Vec3 dcof_g =
      g * trace - Vec3{dot(u.x, g), dot(u.y, g), dot(u.z, g)} + cx * g.x + cy * g.y + cz * g.z;
  const Vec3 fg = g + du_g, cg = g + dcof_g;  // F g, cof(F) g

  // force and Hessian
  const Real shear = young * law.shear, bulk = young * law.bulk, hourglass = young * law.hourglass;
  s.f -= (fg * beyond + (du_g - dcof_g) * Real(0.75)) * shear + cg * (bulk * growth) +
         u.hourglass_displacement * hourglass;
  add_isotropic(s, shear * (Real(0.75) + beyond) * dot(g, g) + hourglass * Real(0.5));
  add_outer(s, fg, 2 * shear * inverse * inverse);
  add_outer(s, cg, bulk);
}
/// The same with ∇u at the center, for corner `at`.
[[gnu::always_inline]] TURGOR_HD inline void add_cell(NodeSystem& s, const CellGradient& u, int at,
                                                      const SolidLaw& law, Real young) {
  const Int3 side = corner_sign(at);
  add_cell(s, u, Vec3{Real(side.x) * law.slope.x, Real(side.y) * law.slope.y, Real(side.z) * law.slope.z},
           law, young);
}

/// Stress of the same cell, in the form that corner_force uses for each corner.
struct CellStress {
  Vec3 x, y,
      z;  // force on a corner at the far end of each axis, −V P/(4 spacing); opposite at the near end [N]
  CornerSums sums;  // for the hourglass forces [m]
  Real hourglass;   // [N/m]
};
/// Stress for ∇u by columns; the sums for the hourglass forces stay zero. Formulas: add_cell.
[[gnu::always_inline]] TURGOR_HD inline CellStress stress_of(Vec3 ux, Vec3 uy, Vec3 uz, const SolidLaw& law,
                                                             Real young) {
  // invariants
  const Vec3 cx = cross(uy, uz), cy = cross(uz, ux), cz = cross(ux, uy);
  const Real trace = ux.x + uy.y + uz.z;
  const Real stretch = 2 * trace + dot(ux, ux) + dot(uy, uy) + dot(uz, uz);
  const Real growth = trace + (cx.x + cy.y + cz.z) + dot(ux, cx);
  const Real beyond = Real(0.25) * stretch / (4 + stretch);
  // cof F − I
  const Vec3 dcof_x = Vec3{trace - ux.x, -uy.x, -uz.x} + cx, dcof_y = Vec3{-ux.y, trace - uy.y, -uz.y} + cy,
             dcof_z = Vec3{-ux.z, -uy.z, trace - uz.z} + cz;
  // columns of P
  const Real shear = young * law.shear, bulk = young * law.bulk * growth, skew = Real(0.75) * shear;
  const Real sides = beyond * shear;
  const Vec3 px = ux * sides + (ux - dcof_x) * skew + dcof_x * bulk + Vec3{sides + bulk, 0, 0},
             py = uy * sides + (uy - dcof_y) * skew + dcof_y * bulk + Vec3{0, sides + bulk, 0},
             pz = uz * sides + (uz - dcof_z) * skew + dcof_z * bulk + Vec3{0, 0, sides + bulk};
  return {px * -law.slope.x, py * -law.slope.y, pz * -law.slope.z, {}, young * law.hourglass};
}
/// `d`: displacements of the corners relative to any one of them [m].
[[gnu::always_inline]] TURGOR_HD inline CellStress cell_stress(const Vec3 (&d)[kCellCorners],
                                                               const SolidLaw& law, Real young) {
  const CornerSums sums = corner_sums(d);
  CellStress s = stress_of(sums.x * law.slope.x, sums.y * law.slope.y, sums.z * law.slope.z, law, young);
  s.sums = sums;
  return s;
}
/// Hourglass force on a corner with displacement d [N].
[[gnu::always_inline]] TURGOR_HD inline Vec3 hourglass_force(const CellStress& s, Vec3 d, Int3 side) {
  const Vec3 plane =
      s.sums.mean + s.sums.x * Real(side.x) + s.sums.y * Real(side.y) + s.sums.z * Real(side.z);
  return (plane * Real(0.125) - d) * s.hourglass;
}
/// Force on a corner with displacement d [N].
[[gnu::always_inline]] TURGOR_HD inline Vec3 corner_force(const CellStress& s, Vec3 d, int corner) {
  const Int3 side = corner_sign(corner);
  return s.x * Real(side.x) + s.y * Real(side.y) + s.z * Real(side.z) + hourglass_force(s, d, side);
}

/// cell_stress and corner_force of a cell whose filled part has its center at `point`, in half cells.
[[gnu::always_inline]] TURGOR_HD inline CellStress cell_stress_at(const Vec3 (&d)[kCellCorners],
                                                                  const SolidLaw& law, Real young,
                                                                  Vec3 point) {
  const CellGradient u = cell_gradient_at(d, 0, law.slope, point);
  CellStress s = stress_of(u.x, u.y, u.z, law, young);
  s.sums = corner_sums(d);
  return s;
}
[[gnu::always_inline]] TURGOR_HD inline Vec3 corner_force_at(const CellStress& s, Vec3 d, int corner,
                                                             Vec3 point) {
  const Vec3 g = shape_gradient(corner, {1, 1, 1}, point);
  return s.x * g.x + s.y * g.y + s.z * g.z + hourglass_force(s, d, corner_sign(corner));
}

/// Deformation gradient of a cell at a point in half cells, and the sum of the squared hourglass
/// displacements.
struct CellDeformation {
  Mat3d f;
  double hourglass;  // Σ |rᵢ|² [m²]
};
CellDeformation cell_deformation(const Vec3d (&u)[kCellCorners], Vec3 spacing, Vec3d point = {});
/// Energy of the same cell per unit of Young's modulus, from the definition; 0 at rest [m³]. `point`: center
/// of the filled part, in half cells.
double cell_energy(const Vec3d (&u)[kCellCorners], Vec3 spacing, double poisson, Vec3d point = {});

}  // namespace turgor::lattice
