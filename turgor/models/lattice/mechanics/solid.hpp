// The law of solid tissue: a cell of the lattice as one element of a body that is the same in every
// direction. Stable Neo-Hookean (Smith, de Goes and Kim 2018) at the cell's middle, and a stiffness against
// the four shapes of a cell that leave its middle alone. Pure functions of a few numbers; equations beside
// their names: docs/models/lattice.md.
#pragma once

#include "turgor/models/lattice/mechanics/element_energies.hpp"

namespace turgor::lattice {

/// On which side of the cell's middle a corner is, -1 or 1 along each axis.
constexpr Int3 corner_side(int n) { return cell_corner(n) * 2 - Int3{1, 1, 1}; }

/// A solid cell per unit of Young's modulus.
struct SolidLaw {
  Vec3 slope;      // of a corner's shape function at the cell's middle, without its signs: 1/(4 step) [1/m]
  Real shear;      // V µ'/E [m³]
  Real bulk;       // V λ'/E [m³]
  Real hourglass;  // V κ/8E, against what bends and twists the cell [m]
};
/// With Lamé's moduli µ and λ of Poisson's ratio in [0, 0.5): µ' = 4/3 µ, λ' = λ + 5/6 µ.
SolidLaw solid_law(Vec3 step, double poisson);

/// Displacements of a cell's corners as their mean and the gradient at the middle, by columns.
struct CellGradient {
  Vec3 x, y, z;  // du/dx, du/dy, du/dz [1]
  Vec3 bent;     // what the corner `at` has moved beyond mean and gradient [m]
};

/// `d`: displacements of the corners beyond that of corner `at` [m].
TURGOR_HD inline CellGradient cell_gradient(const Vec3 (&d)[kCellCorners], int at, Vec3 slope) {
  const Vec3 sum0 = d[0] + d[1], sum1 = d[2] + d[3], sum2 = d[4] + d[5], sum3 = d[6] + d[7];
  const Vec3 x = (d[1] - d[0]) + (d[3] - d[2]) + ((d[5] - d[4]) + (d[7] - d[6]));
  const Vec3 y = (sum1 - sum0) + (sum3 - sum2), low = sum0 + sum1, high = sum2 + sum3, z = high - low;
  const Int3 side = corner_side(at);
  const Vec3 plane = (low + high) + x * Real(side.x) + y * Real(side.y) + z * Real(side.z);
  return {x * slope.x, y * slope.y, z * slope.z, plane * Real(-0.125)};
}

/// The cell seen from corner `at`, E = `young`. Second derivatives are exact at the middle and positive as
/// they are: J is linear in the place of one corner.
TURGOR_HD inline void add_cell(NodeSystem& s, const CellGradient& u, int at, const SolidLaw& law,
                               Real young) {
  const Vec3 cx = cross(u.y, u.z), cy = cross(u.z, u.x), cz = cross(u.x, u.y);
  const Real trace = u.x.x + u.y.y + u.z.z;
  const Real stretch = 2 * trace + dot(u.x, u.x) + dot(u.y, u.y) + dot(u.z, u.z);  // I_C − 3
  const Real growth = trace + (cx.x + cy.y + cz.z) + dot(u.x, cx);                 // J − 1
  const Real inverse = 1 / (4 + stretch), beyond = Real(0.25) * stretch * inverse;

  const Int3 side = corner_side(at);
  const Vec3 g{Real(side.x) * law.slope.x, Real(side.y) * law.slope.y, Real(side.z) * law.slope.z};
  const Vec3 turned = u.x * g.x + u.y * g.y + u.z * g.z;  // ∇u g
  const Vec3 facing =
      g * trace - Vec3{dot(u.x, g), dot(u.y, g), dot(u.z, g)} + cx * g.x + cy * g.y + cz * g.z;
  const Vec3 fg = g + turned, cg = g + facing;  // F g and cof(F) g

  const Real shear = young * law.shear, bulk = young * law.bulk, hourglass = young * law.hourglass;
  s.f -= (fg * beyond + (turned - facing) * Real(0.75)) * shear + cg * (bulk * growth) + u.bent * hourglass;
  add_isotropic(s, shear * (Real(0.75) + beyond) * dot(g, g) + hourglass * Real(0.5));
  add_outer(s, fg, 2 * shear * inverse * inverse);
  add_outer(s, cg, bulk);
}

/// What the same cell bears, as forces on its corners ask for it.
struct CellStress {
  Vec3 x, y, z;         // on corners at the far end of each axis, and minus that on those at the near one [N]
  Vec3 mean, along[3];  // displacements: eight times their mean, and by axis [m]
  Real hourglass;       // [N/m]
};
/// `d`: displacements of the corners beyond that of any one [m].
[[gnu::always_inline]] TURGOR_HD inline CellStress cell_stress(const Vec3 (&d)[kCellCorners],
                                                               const SolidLaw& law, Real young) {
  const Vec3 sum0 = d[0] + d[1], sum1 = d[2] + d[3], sum2 = d[4] + d[5], sum3 = d[6] + d[7];
  const Vec3 low = sum0 + sum1, high = sum2 + sum3, z = high - low;
  const Vec3 x = (d[1] - d[0]) + (d[3] - d[2]) + ((d[5] - d[4]) + (d[7] - d[6]));
  const Vec3 y = (sum1 - sum0) + (sum3 - sum2);
  const Vec3 ux = x * law.slope.x, uy = y * law.slope.y, uz = z * law.slope.z;
  const Vec3 cx = cross(uy, uz), cy = cross(uz, ux), cz = cross(ux, uy);
  const Real trace = ux.x + uy.y + uz.z;
  const Real stretch = 2 * trace + dot(ux, ux) + dot(uy, uy) + dot(uz, uz);
  const Real growth = trace + (cx.x + cy.y + cz.z) + dot(ux, cx);
  const Real beyond = Real(0.25) * stretch / (4 + stretch);
  const Vec3 facing_x = Vec3{trace - ux.x, -uy.x, -uz.x} + cx,
             facing_y = Vec3{-ux.y, trace - uy.y, -uz.y} + cy,
             facing_z = Vec3{-ux.z, -uy.z, trace - uz.z} + cz;
  const Real shear = young * law.shear, bulk = young * law.bulk * growth, skew = Real(0.75) * shear;
  const Real sides = beyond * shear;
  const Vec3 px = ux * sides + (ux - facing_x) * skew + facing_x * bulk + Vec3{sides + bulk, 0, 0},
             py = uy * sides + (uy - facing_y) * skew + facing_y * bulk + Vec3{0, sides + bulk, 0},
             pz = uz * sides + (uz - facing_z) * skew + facing_z * bulk + Vec3{0, 0, sides + bulk};
  return {px * -law.slope.x, py * -law.slope.y, pz * -law.slope.z,
          low + high,        {x, y, z},         young * law.hourglass};
}
/// Force on a corner that has moved by d [N].
[[gnu::always_inline]] TURGOR_HD inline Vec3 corner_force(const CellStress& s, Vec3 d, int corner) {
  const Int3 side = corner_side(corner);
  const Real x = Real(side.x), y = Real(side.y), z = Real(side.z);
  const Vec3 plane = s.mean + s.along[0] * x + s.along[1] * y + s.along[2] * z;
  return s.x * x + s.y * y + s.z * z + (plane * Real(0.125) - d) * s.hourglass;
}

/// The same cell's energy per unit of Young's modulus, from the definition; 0 at rest [m³].
double cell_energy(const Vec3d (&u)[kCellCorners], Vec3 step, double poisson);

}  // namespace turgor::lattice
