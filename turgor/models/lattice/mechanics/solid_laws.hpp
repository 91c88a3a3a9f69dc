// Laws of solid cells other than the one of solid.hpp: exponential and Ogden, and the neo-Hookean one with
// moduli that differ between cells. Each law adds the force and Hessian of a cell at one corner, and gives
// its stress. Of the Hessian's multiple of the identity, `add` returns the factor: a node adds those of its
// eight cells first. All functions are pure and work in SIMD lanes. docs/tissue-laws.md has the equations.
#pragma once

#include <bit>
#include <cstdint>

#include "turgor/models/lattice/mechanics/solid.hpp"

namespace turgor::lattice {

/// True if cells keep a permanent set (solver/viscosity.hpp).
inline bool has_set(const PermanentSet& set) { return set.share > 0; }
/// Most Prony pairs of the body and its layers; 0 = elastic.
int most_pairs(const TissueParams& tissue);
/// True if some cells have fibers.
bool has_fibers(const TissueParams& tissue);
/// Largest Poisson's ratio of the body and its layers. A layer that lets its neighbors slide
/// (TissueLayer::slide) counts as nearly incompressible.
double largest_poisson(const TissueParams& tissue);
/// Energy of the cells of a layer.
inline SolidEnergy energy_of(const TissueLayer& layer, const TissueParams& tissue) {
  return layer.energy.value_or(tissue.energy);
}
/// True if layers have another energy than the body.
bool has_mixed_laws(const TissueParams& tissue);

/// Moduli of a law over Young's modulus: µ and κ; neo-Hookean: µ' and λ' (solid.hpp) [1].
struct LawRatios {
  double shear, bulk;
};
LawRatios law_ratios(SolidEnergy energy, double poisson);
/// Modulus of the hourglass stiffness over the law's shear modulus, times the squared diagonal of the cell
/// [1].
double hourglass_over_shear(SolidEnergy energy);

/// Energy density of a law from its definition, 0 at rest, in the units of the moduli.
struct LawModuli {
  double shear, bulk, stiffening;
  double fiber = 0, fiber_stiffening = 0;
  Vec3d direction;
};
double law_energy(SolidEnergy energy, const Mat3d& f, const LawModuli& m);

/// Moduli of one cell times its volume V.
struct CellModuli {
  Real shear, bulk;  // of the law: V µ and V κ; neo-Hookean: V µ' and V λ' (solid.hpp) [J]
  Real stiffening;   // exponential: b; Ogden: α [1]
  Real hourglass;    // V κ/8 [N/m]
  // fibers of exponential cells: V k1 [J], k2 and unit direction
  Real fiber = 0, fiber_stiffening = 0;
  Vec3 direction;
};

/// Deformation of a cell at one corner, without cancellation at small strains. g: gradient of the corner's
/// shape function.
struct CellStrain {
  Real stretch, growth;  // I_C − 3 and J − 1 [1]
  Vec3 du_g, dcof_g;     // (F − 1) g and (cof F − 1) g [1/m]
  Vec3 fg, cg;           // F g and cof F g [1/m]
  Real g2;               // |g|² [1/m²]
};
[[gnu::always_inline]] TURGOR_HD inline CellStrain cell_strain(const CellGradient& u, Vec3 g) {
  const Vec3 cx = cross(u.y, u.z), cy = cross(u.z, u.x), cz = cross(u.x, u.y);
  const Real trace = u.x.x + u.y.y + u.z.z;
  CellStrain e;
  e.stretch = 2 * trace + dot(u.x, u.x) + dot(u.y, u.y) + dot(u.z, u.z);
  e.growth = trace + (cx.x + cy.y + cz.z) + dot(u.x, cx);
  e.du_g = u.x * g.x + u.y * g.y + u.z * g.z;
  e.dcof_g = g * trace - Vec3{dot(u.x, g), dot(u.y, g), dot(u.z, g)} + cx * g.x + cy * g.y + cz * g.z;
  e.fg = g + e.du_g, e.cg = g + e.dcof_g;
  e.g2 = dot(g, g);
  return e;
}

/// First Piola-Kirchhoff stress times V, by columns [J].
struct CellPiola {
  Vec3 x, y, z;
};
/// a (∇u − (cof F − 1)) + k cof F, by columns.
[[gnu::always_inline]] TURGOR_HD inline CellPiola piola_of(Vec3 ux, Vec3 uy, Vec3 uz, Vec3 dcof_x,
                                                           Vec3 dcof_y, Vec3 dcof_z, Real a, Real k) {
  return {(ux - dcof_x) * a + dcof_x * k + Vec3{k, 0, 0}, (uy - dcof_y) * a + dcof_y * k + Vec3{0, k, 0},
          (uz - dcof_z) * a + dcof_z * k + Vec3{0, 0, k}};
}
/// Columns of cof F − 1, and the invariants of CellStrain.
struct CellCofactor {
  Vec3 x, y, z;
  Real stretch, growth;
};
[[gnu::always_inline]] TURGOR_HD inline CellCofactor cell_cofactor(Vec3 ux, Vec3 uy, Vec3 uz) {
  const Vec3 cx = cross(uy, uz), cy = cross(uz, ux), cz = cross(ux, uy);
  const Real trace = ux.x + uy.y + uz.z;
  return {Vec3{trace - ux.x, -uy.x, -uz.x} + cx, Vec3{-ux.y, trace - uy.y, -uz.y} + cy,
          Vec3{-ux.z, -uy.z, trace - uz.z} + cz, 2 * trace + dot(ux, ux) + dot(uy, uy) + dot(uz, uz),
          trace + (cx.x + cy.y + cz.z) + dot(ux, cx)};
}
/// The symmetric outer product a bᵀ + b aᵀ.
TURGOR_HD inline void add_symmetric(NodeSystem& s, Vec3 a, Vec3 b) {
  s.xx += 2 * a.x * b.x, s.yy += 2 * a.y * b.y, s.zz += 2 * a.z * b.z;
  s.xy += a.x * b.y + b.x * a.y, s.xz += a.x * b.z + b.x * a.z, s.yz += a.y * b.z + b.y * a.z;
}

// ---------------------------------------------------------------- powers and exponentials in lanes

/// max(a, b), min(a, b) and max(−b, min(a, b)) for b ≥ 0. Bits of floating-point numbers order as integers
/// do. Compilers turn comparisons with constants into branches, which keep some loops from being vectorized.
[[gnu::always_inline]] TURGOR_HD inline Real at_least(Real a, Real b) {
  const auto bits = std::bit_cast<std::int32_t>(a), bound = std::bit_cast<std::int32_t>(b);
  return std::bit_cast<Real>(bits > bound ? bits : bound);
}
[[gnu::always_inline]] TURGOR_HD inline Real at_most(Real a, Real b) {
  const auto bits = std::bit_cast<std::int32_t>(a), bound = std::bit_cast<std::int32_t>(b);
  return std::bit_cast<Real>(bits < bound ? bits : bound);
}
[[gnu::always_inline]] TURGOR_HD inline Real within(Real a, Real b) {
  const auto bits = std::bit_cast<std::uint32_t>(a), bound = std::bit_cast<std::uint32_t>(-b);
  return at_most(std::bit_cast<Real>(bits < bound ? bits : bound), b);  // negative ones order backwards
}

/// e^x for x from −80 to 80, to 3 units in the last digit. Its bits do not depend on a library.
[[gnu::always_inline]] TURGOR_HD inline Real lane_exp(Real x) {
  // x = n ln 2 + f: the sum with 3·2²² is rounded to whole numbers, and has n in its last bits
  constexpr Real kShift = 12582912;
  const Real shifted = x * Real(1.44269504) + kShift, n = shifted - kShift;
  const Real f = (x - n * Real(0.693145752)) - n * Real(1.42860677e-6);  // ln 2 in two parts
  const Real p =
      1 + f * (1 + f * (Real(0.5) +
                        f * (Real(1) / 6 + f * (Real(1) / 24 + f * (Real(1) / 120 + f * (Real(1) / 720))))));
  // n is added to the exponent of e^f
  return std::bit_cast<Real>(std::bit_cast<std::uint32_t>(p) + (std::bit_cast<std::uint32_t>(shifted) << 23));
}
/// a^(−1/3) for positive a: two steps of third order from a guess by the exponent's bits.
///   y ← y (1 + e/3 + 2e²/9)      e = 1 − a y³
[[gnu::always_inline]] TURGOR_HD inline Real lane_inverse_cube_root(Real a) {
  const Real bits = Real(std::bit_cast<std::int32_t>(a));
  Real y = std::bit_cast<Real>(std::int32_t(0x54a2fa8c) - std::int32_t(bits * Real(0.333333333)));
  TURGOR_UNROLL
  for (int n = 0; n < 2; n++) {
    const Real e = 1 - a * y * (y * y);
    y += y * e * (Real(1) / 3 + e * (Real(2) / 9));
  }
  return y;
}

// ---------------------------------------------------------------- neo-Hookean

/// Stable neo-Hookean law with moduli by cell. Formulas: add_cell and stress_of in solid.hpp.
struct NeoHookeanLaw {
  static constexpr bool kHasFibers = false;
  [[gnu::always_inline]] TURGOR_HD static Real add(NodeSystem& s, const CellGradient& u, Vec3 g,
                                                   const CellModuli& m) {
    const CellStrain e = cell_strain(u, g);
    const Real inverse = 1 / (4 + e.stretch);
    const Real sides = Real(0.25) * e.stretch * inverse * m.shear, skew = Real(0.75) * m.shear;
    s.f -= e.fg * sides;
    s.f -= (e.du_g - e.dcof_g) * skew;
    s.f -= e.cg * (m.bulk * e.growth);
    add_outer(s, e.fg, 2 * m.shear * inverse * inverse);
    add_outer(s, e.cg, m.bulk);
    return (skew + sides) * e.g2;
  }
  [[gnu::always_inline]] TURGOR_HD static CellPiola piola(Vec3 ux, Vec3 uy, Vec3 uz, const CellModuli& m) {
    const CellCofactor c = cell_cofactor(ux, uy, uz);
    const Real beyond = Real(0.25) * c.stretch / (4 + c.stretch), sides = m.shear * beyond;
    CellPiola p = piola_of(ux, uy, uz, c.x, c.y, c.z, Real(0.75) * m.shear, m.bulk * c.growth);
    p.x += ux * sides + Vec3{sides, 0, 0}, p.y += uy * sides + Vec3{0, sides, 0};
    p.z += uz * sides + Vec3{0, 0, sides};
    return p;
  }
};

// ---------------------------------------------------------------- exponential

/// Largest exponent b (Ī₁ − 3). Beyond, the energy goes on linearly in Ī₁, so that numbers stay finite.
constexpr Real kLargestExponent = 10;
/// Least J. Below, J^(−2/3) goes on linearly in J, so that inverted cells are pushed back.
constexpr Real kLeastGrowth = Real(0.1);

/// Exponential law of soft tissue [Demiray 1972], isochoric part and volume apart:
///   Ψ = µ/2b (exp(b (Ī₁ − 3)) − 1) + κ/2 (J − 1)²       Ī₁ = r I_C,  r = J^(−2/3)
///   P = µ c p + κ (J − 1) cof F       c = exp(b (Ī₁ − 3)),  p = r F + ½ r' I_C cof F
///   p = r (F − cof F) + r (3 (J − 1) − (I_C − 3))/3J cof F                    without cancellation
///   H = V (µ c (r |g|² I + 2b (p g)(p g)ᵀ − ⅔ r/J (F g (cof F g)ᵀ + cof F g (F g)ᵀ) + 5/9 r I_C/J² (cof F
///   g)(cof F
///       g)ᵀ) + κ (cof F g)(cof F g)ᵀ)
/// H is exact and positive definite: without b and κ, it is at least ⅕ V µ c r |g|², by completing the square
/// and |F g|² ≤ I_C |g|². Small strains see µ and κ.
struct ExponentialLaw {
  static constexpr bool kHasFibers = false;
  struct Factors {
    Real r, inverse;  // r; 1/J
    Real bend;        // r + ½ r' I_C
    Real shear;       // V µ c [J]
    Real slope;       // 2b; 0 beyond the largest exponent
    Real square;      // 5/9 r I_C/J²
    Real cross;       // −⅔ r/J
  };
  [[gnu::always_inline]] TURGOR_HD static Factors factors(Real stretch, Real growth, const CellModuli& m) {
    const Real j = 1 + growth, bounded = at_least(j, kLeastGrowth);
    const Real root = lane_inverse_cube_root(bounded), r0 = root * root, inverse = r0 * root;
    const Real lack = bounded - j;  // 0 except in cells that are nearly inverted
    const Real r = r0 * (1 + Real(2) / 3 * lack * inverse);
    const Real i1 = 3 + stretch, x = m.stiffening * (r * i1 - 3);
    const Real c = lane_exp(within(x, kLargestExponent));
    return {r,
            inverse,
            r0 * inverse * (Real(1) / 3) * (3 * growth - stretch + 5 * lack),
            m.shear * c,
            x < kLargestExponent ? 2 * m.stiffening : 0,
            Real(5) / 9 * r0 * i1 * inverse * inverse,
            -Real(2) / 3 * r0 * inverse};
  }
  [[gnu::always_inline]] TURGOR_HD static Real add(NodeSystem& s, const CellGradient& u, Vec3 g,
                                                   const CellModuli& m) {
    const CellStrain e = cell_strain(u, g);
    const Factors k = factors(e.stretch, e.growth, m);
    const Vec3 p = (e.du_g - e.dcof_g) * k.r + e.cg * k.bend;
    s.f -= p * k.shear;
    s.f -= e.cg * (m.bulk * e.growth);
    add_outer(s, p, k.shear * k.slope);
    add_symmetric(s, e.cg, e.fg * (k.shear * k.cross) + e.cg * (Real(0.5) * (k.shear * k.square + m.bulk)));
    return k.shear * k.r * e.g2;
  }
  [[gnu::always_inline]] TURGOR_HD static CellPiola piola(Vec3 ux, Vec3 uy, Vec3 uz, const CellModuli& m) {
    const CellCofactor c = cell_cofactor(ux, uy, uz);
    const Factors k = factors(c.stretch, c.growth, m);
    return piola_of(ux, uy, uz, c.x, c.y, c.z, k.shear * k.r, k.shear * k.bend + m.bulk * c.growth);
  }
};

/// Exponential law with one family of fibers along the unit direction a [Gasser, Ogden, Holzapfel 2006,
/// without dispersion]. Fibers bear tension only:
///   Ψ = Ψ_exponential + k1/2k2 (exp(k2 ⟨Ī₄ − 1⟩²) − 1)       Ī₄ = r |F a|²
///   q = ∂Ī₄/∂x = 2 r s F a − ⅔ r Ī/J cof F g       s = a·g, Ī = |F a|²
///   H += V (Ψ'' q qᵀ + Ψ' r (2 s² I − 4/3 s/J (F a (cof F g)ᵀ + cof F g (F a)ᵀ) + 10/9 Ī/J² cof F g (cof F
///   g)ᵀ))
/// H is exact and positive semidefinite, since |F a|² = Ī and (8/3)² < 8 · 10/9.
struct FiberedExponentialLaw {
  static constexpr bool kHasFibers = true;
  struct Factors {
    Real r, inverse;     // r and 1/J
    Real stress, slope;  // V Ψ' and V Ψ'' [J]
  };
  [[gnu::always_inline]] TURGOR_HD static Factors factors(Real stretch, Real growth, const CellModuli& m) {
    // Ī₄ − 1 without cancellation: r (|F a|² − 1) + (r − 1)
    const Real j = 1 + growth, bounded = at_least(j, kLeastGrowth);
    const Real root = lane_inverse_cube_root(bounded), r = root * root;
    const Real strain = r * stretch + (root - 1) * (root + 1), e = strain > 0 ? strain : 0;
    const Real y = m.fiber_stiffening * e * e;
    const Real stiff = m.fiber * lane_exp(at_most(y, kLargestExponent));
    return {r, r * root, stiff * e, strain > 0 ? stiff * (y < kLargestExponent ? 1 + 2 * y : Real(1)) : 0};
  }
  /// (F − 1) a
  [[gnu::always_inline]] TURGOR_HD static Vec3 extension(Vec3 ux, Vec3 uy, Vec3 uz, Vec3 a) {
    return ux * a.x + uy * a.y + uz * a.z;
  }
  [[gnu::always_inline]] TURGOR_HD static Real add(NodeSystem& s, const CellGradient& u, Vec3 g,
                                                   const CellModuli& m) {
    const Real isotropic = ExponentialLaw::add(s, u, g, m);
    const CellStrain e = cell_strain(u, g);
    const Vec3 more = extension(u.x, u.y, u.z, m.direction), fa = m.direction + more;
    const Real stretch = 2 * dot(m.direction, more) + dot(more, more);
    const Factors k = factors(stretch, e.growth, m);
    const Real along = dot(m.direction, g), i4 = 1 + stretch, by = k.r * k.stress;
    const Vec3 q = (fa * along - e.cg * (Real(1) / 3 * i4 * k.inverse)) * (2 * k.r);
    s.f -= q * k.stress;
    add_outer(s, q, k.slope);
    add_symmetric(s, e.cg,
                  fa * (Real(-4) / 3 * by * along * k.inverse) +
                      e.cg * (Real(5) / 9 * by * i4 * k.inverse * k.inverse));
    return isotropic + 2 * by * along * along;
  }
  [[gnu::always_inline]] TURGOR_HD static CellPiola piola(Vec3 ux, Vec3 uy, Vec3 uz, const CellModuli& m) {
    CellPiola p = ExponentialLaw::piola(ux, uy, uz, m);
    const CellCofactor c = cell_cofactor(ux, uy, uz);
    const Vec3 a = m.direction, more = extension(ux, uy, uz, a), fa = a + more;
    const Real stretch = 2 * dot(a, more) + dot(more, more);
    const Factors k = factors(stretch, c.growth, m);
    const Real by = 2 * k.r * k.stress, turned = Real(-1) / 3 * by * (1 + stretch) * k.inverse;
    p.x += fa * (by * a.x) + c.x * turned + Vec3{turned, 0, 0};
    p.y += fa * (by * a.y) + c.y * turned + Vec3{0, turned, 0};
    p.z += fa * (by * a.z) + c.z * turned + Vec3{0, 0, turned};
    return p;
  }
};

}  // namespace turgor::lattice
