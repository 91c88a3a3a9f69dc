// Exponential law of skin: an incompressible membrane with one family of fibers along Langer's lines. Pure
// functions for CPU lanes and GPU threads, as in element_energies.hpp. The state without stress follows from
// the tension in the CT (skin_calibration.hpp). docs/skin-law.md has the derivation.
#pragma once

#include "turgor/models/lattice/mechanics/solid_laws.hpp"

namespace turgor::lattice {

/// Constants of the exponential law, and the stretches of the CT from the state without stress.
struct ExponentialSkin {
  Real shear = 0, stiffening = 0;              // µ [N/m], b
  Real fiber = 0, fiber_stiffening = 0;        // k1 [N/m], k2
  Real dispersion = 0;                         // κ
  Real along = 1, across = 1, rest_share = 1;  // λ_along, λ_across, area without stress over area in the CT
};

/// Largest exponents. Beyond, the matrix is linear in Ī and the fibers are quadratic in E. Measured skin
/// reaches 2.2 (docs/skin-law.md).
constexpr Real kLargestSkinExponent = 5;
/// Least D = det C of the formulas. Below, 1/D goes on linearly, so that folded triangles are pushed back.
constexpr Real kLeastSkinDeterminant = Real(0.04);

/// Deformation of a triangle from the state without stress. f and g are the images of unit vectors along and
/// across Langer's lines.
///   C = (f·f  f·g; f·g  g·g)      D = det C      Ī = C₁₁ + C₂₂ + 1/D
///   W = µ/2b (exp(b (Ī − 3)) − 1) + k1/2k2 (exp(k2 E²) − 1),  E = κ (Ī − 3) + (1 − 3κ)(C₁₁ − 1) > 0
/// [Demiray 1972; Gasser, Ogden, Holzapfel 2006], per area without stress
struct SkinStrain {
  Vec3 f, g, normal;  // normal: f × g
  Real along, across, shear, determinant;
  Real inverse, inverse_slope;  // 1/D and −∂(1/D)/∂D
  Real matrix, matrix_slope;    // ∂W/∂Ī of the matrix and its derivative [N/m]
  Real fiber, fiber_slope;      // ∂W/∂E of the fibers and its derivative [N/m]
  Real share;                   // 1 − 3κ
  Real matrix_exponent, fiber_exponent;
};
[[gnu::always_inline]] TURGOR_HD inline SkinStrain skin_strain(Vec3 f, Vec3 g, const ExponentialSkin& law) {
  SkinStrain e;
  e.f = f, e.g = g, e.normal = cross(f, g);
  e.along = dot(f, f), e.across = dot(g, g), e.shear = dot(f, g), e.determinant = dot(e.normal, e.normal);
  // 1/D, linear below the least D
  const Real d = e.determinant > kLeastSkinDeterminant ? e.determinant : kLeastSkinDeterminant, r = 1 / d;
  e.inverse = r + (d - e.determinant) * r * r, e.inverse_slope = r * r;
  // matrix: exponential up to the largest exponent, linear beyond
  const Real invariant = e.along + e.across + e.inverse - 3, x = law.stiffening * invariant;
  e.matrix_exponent = x < kLargestSkinExponent ? positive(x) : kLargestSkinExponent;
  e.matrix = Real(0.5) * law.shear * lane_exp(e.matrix_exponent);
  e.matrix_slope = x < kLargestSkinExponent ? law.stiffening * e.matrix : 0;
  // fibers bear no pressure
  e.share = 1 - 3 * law.dispersion;
  const Real strain = positive(law.dispersion * invariant + e.share * (e.along - 1));
  const Real y = law.fiber_stiffening * strain * strain;
  e.fiber_exponent = y < kLargestSkinExponent ? y : kLargestSkinExponent;
  const Real stiff = law.fiber * lane_exp(e.fiber_exponent);
  e.fiber = stiff * strain;
  e.fiber_slope = strain > 0 ? stiff * (y < kLargestSkinExponent ? 1 + 2 * y : Real(1)) : 0;
  return e;
}

/// Derivatives of W with respect to f and g, per area without stress [N/m].
///   ∂Ī = 2 f·∂f + 2 g·∂g − ∂D/D²      ∂D/∂f = 2 (C₂₂ f − C₁₂ g),  ∂D/∂g = 2 (C₁₁ g − C₁₂ f)
struct SkinStress {
  Vec3 f, g;
};
[[gnu::always_inline]] TURGOR_HD inline SkinStress skin_stress(const SkinStrain& e, Real dispersion) {
  const Real both = 2 * (e.matrix + dispersion * e.fiber), k = both * e.inverse_slope;
  return {e.f * (both - k * e.across + 2 * e.share * e.fiber) + e.g * (k * e.shear),
          e.g * (both - k * e.along) + e.f * (k * e.shear)};
}

/// Adds force and Hessian at the first corner of a triangle, as add_skin_fiber. With a and c the derivatives
/// of f and g by this corner, h = a g − c f and t the unit vector along h × n:
///   p = ∂Ī/∂x = 2 (a f + c g) − 2 h × (f × g)/D²,  q = ∂E/∂x = κ p + 2 (1 − 3κ) a f
///   H = W_Ī' p pᵀ + W_E' q qᵀ + 2 (W_Ī + κ W_E)((a² + c²) I + |h|²/D² (3 t tᵀ − n nᵀ)) + 2 (1 − 3κ) W_E a² I
/// The stiffness along the normal n, which is the tension's, is kept at 0 at least.
[[gnu::always_inline]] TURGOR_HD inline void add_skin_exponential(NodeSystem& s, Vec3 edge1, Vec3 edge2,
                                                                  Vec3 along, Vec3 across, Real area,
                                                                  const ExponentialSkin& law) {
  along = along * law.along, across = across * law.across, area *= law.rest_share;
  const SkinStrain e =
      skin_strain(edge1 * along.y + edge2 * along.z, edge1 * across.y + edge2 * across.z, law);
  const Real a = along.x, c = across.x;
  // force
  const SkinStress stress = skin_stress(e, law.dispersion);
  s.f -= (stress.f * a + stress.g * c) * area;
  // invariants' gradients
  const Vec3 h = e.g * a - e.f * c, turned = cross(h, e.normal);
  const Vec3 p = (e.f * a + e.g * c) * 2 - turned * (2 * e.inverse_slope);
  const Vec3 q = p * law.dispersion + e.f * (2 * e.share * a);
  add_outer(s, p, area * e.matrix_slope);
  add_outer(s, q, area * e.fiber_slope);
  // second derivatives of the invariants
  const bool is_folded = !(e.determinant > kLeastSkinDeterminant);
  const Real both = 2 * area * (e.matrix + law.dispersion * e.fiber), h2 = dot(h, h);
  const Real plane = both * (a * a + c * c) + 2 * area * e.share * e.fiber * (a * a);
  const Real curved = both * h2 * e.inverse_slope, inverse = 1 / nonzero(e.determinant);
  add_isotropic(s, plane);
  add_outer(s, turned, is_folded ? 0 : 3 * curved * inverse / nonzero(h2));
  add_outer(s, e.normal, -(curved < plane ? curved : plane) * inverse);
}

/// Growth of the exponents of a triangle, 0 at least, if its first corner moves by d.
[[gnu::always_inline]] TURGOR_HD inline Real skin_exponent_growth(Vec3 edge1, Vec3 edge2, Vec3 along,
                                                                  Vec3 across, const ExponentialSkin& law,
                                                                  Vec3 d) {
  along = along * law.along, across = across * law.across;
  const Vec3 f = edge1 * along.y + edge2 * along.z, g = edge1 * across.y + edge2 * across.z;
  const SkinStrain now = skin_strain(f, g, law), moved = skin_strain(f + d * along.x, g + d * across.x, law);
  const Real matrix = moved.matrix_exponent - now.matrix_exponent,
             fiber = moved.fiber_exponent - now.fiber_exponent;
  return positive(matrix > fiber ? matrix : fiber);
}
/// Smaller growths need no shorter step.
constexpr Real kCheckedGrowth = Real(0.05);
/// Share of a Newton step that lets an exponent grow by G. An exponential k (exp(G) − 1) that balances a
/// force needs ln(1 + G)/G of the step; the share is less, so that no step ends where skin is stiff beyond
/// measure.
TURGOR_HD inline Real skin_step_share(Real growth) { return 1 / (1 + Real(0.5) * growth); }

/// Forces of add_skin_exponential at all three corners.
[[gnu::always_inline]] TURGOR_HD inline CornerForces skin_exponential_forces(Vec3 edge1, Vec3 edge2,
                                                                             Vec3 along, Vec3 across,
                                                                             Real area,
                                                                             const ExponentialSkin& law) {
  along = along * law.along, across = across * law.across, area *= law.rest_share;
  const SkinStrain e =
      skin_strain(edge1 * along.y + edge2 * along.z, edge1 * across.y + edge2 * across.z, law);
  const SkinStress stress = skin_stress(e, law.dispersion);
  const Vec3 p = stress.f * -area, q = stress.g * -area;
  return {{p * along.x + q * across.x, p * along.y + q * across.y, p * along.z + q * across.z}};
}

}  // namespace turgor::lattice
