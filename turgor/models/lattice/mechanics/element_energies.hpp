// Energies and constraints of single elements: spring, volume of a tetrahedron, skin triangle. All are pure
// functions of a few numbers, for CPU lanes and GPU threads. docs/models/lattice.md has the derivations and
// the differences from the paper.
#pragma once

#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/config.hpp"
#include "turgor/geometry/lattice.hpp"
#include "turgor/models/lattice/model/params.hpp"

namespace turgor::lattice {

TURGOR_HD inline Real positive(Real a) { return a > 0 ? a : 0; }
/// Divisor that is zero only where the quotient is unused. A branch would prevent SIMD.
TURGOR_HD inline Real nonzero(Real a) { return a > Real(1e-30) ? a : Real(1e-30); }
TURGOR_HD inline Real square_root(Real a) { return __builtin_sqrtf(a); }

/// Factor of a tetrahedron's stiffness: the product of the root stiffnesses at the ends of the cell's
/// diagonal, 0 if a corner is not body.
TURGOR_HD inline Real tet_stiffness(Real diagonal_a, Real diagonal_b, Real corner_a, Real corner_b,
                                    Real corner_c) {
  const bool whole = (corner_a > 0) & (corner_b > 0) & (corner_c > 0);
  return whole ? diagonal_a * diagonal_b : 0;
}

// ---------------------------------------------------------------- PBD: projections

/// Projects the spring constraint C = |d| − rest with d = b − a. Returns s: a moves by +wa s d, b by −wb s d.
///   s = k (|d| − rest) / ((wa + wb) |d|)      k: stiffness in [0, 1], w: inverse masses
/// [Müller et al. 2007, eq. 10]
TURGOR_HD inline Real project_spring(Vec3 d, Real rest, Real stiffness, Real wa, Real wb) {
  const Real length = square_root(dot(d, d));
  return stiffness * (length - rest) / nonzero((wa + wb) * length);
}

/// Gradients of 6 V with respect to the last three corners of the tetrahedron (0, e1, e2, e3). The gradient
/// of the first corner is minus their sum.
struct VolumeGradients {
  Vec3 g1, g2, g3;
};
TURGOR_HD inline VolumeGradients volume_gradients(Vec3 e1, Vec3 e2, Vec3 e3) {
  return {cross(e2, e3), cross(e3, e1), cross(e1, e2)};
}

/// Projects the volume constraint C = 6 (V − V_rest). Returns s: corner i moves by w_i s ∇_i with ∇_i the
/// gradient of 6 V.
///   s = −k C / Σ w_i |∇_i|²      k: stiffness in [0, 1]
/// [Müller et al. 2007, eq. 8]
TURGOR_HD inline Real project_volume(Vec3 e1, const VolumeGradients& g, Real rest_volume, Real stiffness,
                                     Real w0, Real w1, Real w2, Real w3) {
  const Vec3 g0 = g.g1 + g.g2 + g.g3;
  const Real sum = w0 * dot(g0, g0) + w1 * dot(g.g1, g.g1) + w2 * dot(g.g2, g.g2) + w3 * dot(g.g3, g.g3);
  const Real change = dot(e1, g.g1) - 6 * rest_volume;
  return -stiffness * change / nonzero(sum);
}

/// Position corrections of the corners of a triangle [m].
struct SkinShift {
  Vec3 a, b, c;
};

/// Projects the skin tension constraint C = A − A_rest; w are the inverse masses.
///   ∇_i = ½ (opposite side) × n/|n|,  n = (b − a) × (c − a)      so |∇_i|² = ¼ (opposite side)²
///   Δx_i = −k w_i C ∇_i / Σ w_j |∇_j|²,  k = min(1, k₀ (1 + β max(0, C)/A_rest))
/// [STC Algorithm 1, corrected]
TURGOR_HD inline SkinShift project_skin(Vec3 a, Vec3 b, Vec3 c, Vec3 w, Real rest_area, Real stiffness,
                                        Real amplification) {
  const Vec3 side_a = b - c, side_b = c - a, side_c = a - b;
  const Vec3 n = cross(side_b, side_c);  // (b − a) × (c − a)
  const Real twice_area = square_root(dot(n, n)), change = Real(0.5) * twice_area - rest_area;
  const Real sum = w.x * dot(side_a, side_a) + w.y * dot(side_b, side_b) + w.z * dot(side_c, side_c);
  const Real amplified = stiffness * (1 + amplification * positive(change) / nonzero(rest_area));
  const bool degenerate = !(twice_area > Real(1e-6) * rest_area);
  const Real k = degenerate ? 0 : amplified < 1 ? amplified : 1;
  const Real s = -2 * k * change / nonzero(sum * twice_area);
  return {cross(side_a, n) * (s * w.x), cross(side_b, n) * (s * w.y), cross(side_c, n) * (s * w.z)};
}

// ---------------------------------------------------------------- VBD: force and Hessian at one node

/// Force f = −∂E/∂x [N] and Hessian ∂²E/∂x² [N/m] of the energy at one node. The Hessian is projected to be
/// positive semidefinite.
struct NodeSystem {
  Vec3 f;
  Real xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;
};

TURGOR_HD inline void add(NodeSystem& s, const NodeSystem& more) {
  s.f += more.f;
  s.xx += more.xx, s.yy += more.yy, s.zz += more.zz, s.xy += more.xy, s.xz += more.xz, s.yz += more.yz;
}
TURGOR_HD inline void add_outer(NodeSystem& s, Vec3 g, Real k) {
  const Vec3 kg = g * k;
  s.xx += kg.x * g.x, s.yy += kg.y * g.y, s.zz += kg.z * g.z;
  s.xy += kg.x * g.y, s.xz += kg.x * g.z, s.yz += kg.y * g.z;
}
TURGOR_HD inline void add_isotropic(NodeSystem& s, Real k) { s.xx += k, s.yy += k, s.zz += k; }

/// Spring with stiffness k; d leads from this node to the other one, l = |d|, n = d/l.
///   E = ½ k (l − rest)²
///   f = k (l − rest) n
///   H = k n nᵀ + k max(0, 1 − rest/l) (I − n nᵀ)      clamped: no negative lateral stiffness
TURGOR_HD inline void add_spring(NodeSystem& s, Vec3 d, Real rest, Real k) {
  const Real inverse_length = 1 / square_root(dot(d, d)), stretch = 1 - rest * inverse_length;
  const Real lateral = k * positive(stretch);
  s.f += d * (k * stretch);
  add_outer(s, d, (k - lateral) * inverse_length * inverse_length);
  add_isotropic(s, lateral);
}

/// Volume energy of a tetrahedron; g = ∂V/∂x at this node, `stiffness` = κ/V₀, `change` = V − V₀.
///   E = ½ κ V₀ (V/V₀ − 1)²
///   f = −κ/V₀ (V − V₀) g
///   H = κ/V₀ g gᵀ      exact: V is linear in one corner
TURGOR_HD inline void add_volume(NodeSystem& s, Vec3 g, Real stiffness, Real change) {
  s.f -= g * (stiffness * change);
  add_outer(s, g, stiffness);
}

/// Skin triangle that resists area, at its corner a; `stiffness` = K/A_rest, s = A − A_rest.
///   E = K/A_rest (½ s² + β max(0, s)³/(3 A_rest))
///   g = ∂A/∂a = ½ (b − c) × u,  u: unit normal
///   f = −k s g,  k = K/A_rest (1 + β max(0, s)/A_rest)
///   H = k g gᵀ + k max(0, s) |b − c|²/(4 A) u uᵀ      with k held constant
/// [STC eq. 3]
TURGOR_HD inline void add_skin_area(NodeSystem& s, Vec3 a, Vec3 b, Vec3 c, Real rest_area, Real stiffness,
                                    Real amplification) {
  const Vec3 n = cross(b - a, c - a);
  const Real twice_area = square_root(dot(n, n)), change = Real(0.5) * twice_area - rest_area;
  const bool degenerate = !(twice_area > Real(1e-6) * rest_area);
  const Real inverse = 1 / nonzero(twice_area), growth = positive(change / nonzero(rest_area));
  const Vec3 u = n * inverse, opposite = b - c, g = cross(opposite, u) * Real(0.5);
  const Real k = degenerate ? 0 : stiffness * (1 + amplification * growth);
  s.f -= g * (k * change);
  add_outer(s, g, k);
  // lateral stiffness of a taut membrane; without it the sweeps diverge
  add_outer(s, u, k * positive(change) * dot(opposite, opposite) * (Real(0.5) * inverse));
}

/// Constants of the fiber law. `rest` is the stretch at which a fiber has no tension.
struct FiberLaw {
  Real rest_along, rest_across, stiffness, shear, amplification;  // [1] [1] [N/m] [N/m] [1]
};

/// Fiber with g = F d, l = |g|, s = l − rest, at a corner whose coefficient in g is c; `stiffness` = K A₀.
///   E = K A₀ (½ s² + β max(0, s)³/(3 rest))
///   f = −k c s g/l,  k = K A₀ (1 + β max(0, s)/rest)
///   H = k c² (g gᵀ/l² + max(0, s)/l (I − g gᵀ/l²))      with k held constant
TURGOR_HD inline void add_fiber(NodeSystem& s, Vec3 g, Real c, Real rest, Real stiffness,
                                Real amplification) {
  const Real length = square_root(dot(g, g)), strain = length - rest, steeper = amplification / rest;
  const Real inverse_length = length > 0 ? 1 / nonzero(length) : 0;
  const Real kc = stiffness * c * (1 + steeper * positive(strain)), k = kc * c;
  const Real lateral = k * positive(strain) * inverse_length;
  s.f -= g * (kc * strain * inverse_length);
  add_outer(s, g, (k - lateral) * inverse_length * inverse_length);
  add_isotropic(s, lateral);
}

/// Fiber law of skin: fibers along and across Langer's lines, and shear between them. f = F d_along and g = F
/// d_across; the result is at the first corner. `edge1` and `edge2` lead from it to the others; `along` and
/// `across` are the coefficients in that order.
///   E = E_fiber(f) + E_fiber(g) + ½ G A₀ (f · g)²      G: law.shear
/// [docs/models/lattice.md, fiber law]
TURGOR_HD inline void add_skin_fiber(NodeSystem& s, Vec3 edge1, Vec3 edge2, Vec3 along, Vec3 across,
                                     Real area, const FiberLaw& law) {
  const Vec3 f = edge1 * along.y + edge2 * along.z, g = edge1 * across.y + edge2 * across.z;
  // fibers
  add_fiber(s, f, along.x, law.rest_along, law.stiffness * area, law.amplification);
  add_fiber(s, g, across.x, law.rest_across, law.stiffness * area, law.amplification);
  // shear
  const Vec3 sheared = f * across.x + g * along.x;
  s.f -= sheared * (law.shear * area * dot(f, g));
  add_outer(s, sheared, law.shear * area);
}

/// Length of a fiber, positive, so that a fiber without length has no force and needs no branch.
[[gnu::always_inline]] TURGOR_HD inline Real fiber_length(Vec3 g) {
  return square_root(dot(g, g) + Real(1e-30));
}
/// Derivative ∂E/∂g of the fiber energy (add_fiber) over g, for `stiffness` = K A₀.
[[gnu::always_inline]] TURGOR_HD inline Real fiber_stress_factor(Vec3 g, Real rest, Real stiffness,
                                                                 Real amplification) {
  const Real length = fiber_length(g), stretch = positive(length - rest);
  return (stiffness + stiffness * amplification / rest * stretch) * (1 - rest / length);
}
/// Derivative ∂E/∂g of the fiber energy.
TURGOR_HD inline Vec3 fiber_stress(Vec3 g, Real rest, Real stiffness, Real amplification) {
  return g * fiber_stress_factor(g, rest, stiffness, amplification);
}
/// Gradient of the fiber law of skin (add_skin_fiber) at a corner with the coefficients `along` and `across`
/// in f and g [N].
[[gnu::always_inline]] TURGOR_HD inline Vec3 skin_fibers_gradient(Vec3 f, Vec3 g, Real along, Real across,
                                                                  Real area, const FiberLaw& law) {
  const Real k = law.stiffness * area, sheared = law.shear * area * dot(f, g);
  const Real of_f = fiber_stress_factor(f, law.rest_along, k, law.amplification),
             of_g = fiber_stress_factor(g, law.rest_across, k, law.amplification);
  return f * (of_f * along + sheared * across) + g * (of_g * across + sheared * along);
}

/// Mean products of the coefficients of a corner in f and g over an element [1/m²].
struct FiberProducts {
  Real along, mixed, across;
};
/// Adds the Hessian of the same law for fibers f and g that hardly vary in the element. Formulas: add_fiber
/// and add_skin_fiber.
[[gnu::always_inline]] TURGOR_HD inline void add_skin_fibers_hessian(NodeSystem& s, Vec3 f, Vec3 g,
                                                                     const FiberProducts& c, Real area,
                                                                     const FiberLaw& law) {
  // fibers
  const auto fiber = [&](Vec3 v, Real rest, Real product) {
    const Real length = fiber_length(v), stretch = positive(length - rest), inverse_length = 1 / length;
    const Real k = law.stiffness * area * product * (1 + law.amplification / rest * stretch);
    const Real lateral = k * stretch * inverse_length;
    add_isotropic(s, lateral);
    return (k - lateral) * inverse_length * inverse_length;
  };
  const Real of_f = fiber(f, law.rest_along, c.along), of_g = fiber(g, law.rest_across, c.across);
  // fibers and shear
  const Real shear = law.shear * area, mixed = shear * c.mixed;
  const Vec3 kf = f * (of_f + shear * c.across) + g * mixed, kg = g * (of_g + shear * c.along) + f * mixed;
  s.xx += kf.x * f.x + kg.x * g.x, s.yy += kf.y * f.y + kg.y * g.y, s.zz += kf.z * f.z + kg.z * g.z;
  s.xy += kf.x * f.y + kg.x * g.y, s.xz += kf.x * f.z + kg.x * g.z, s.yz += kf.y * f.z + kg.y * g.z;
}

/// Forces on the three corners of a triangle [N].
struct CornerForces {
  Vec3 on[3];
};
/// Forces of add_skin_fiber at all three corners.
TURGOR_HD inline CornerForces skin_fiber_forces(Vec3 edge1, Vec3 edge2, Vec3 along, Vec3 across, Real area,
                                                const FiberLaw& law) {
  const Vec3 f = edge1 * along.y + edge2 * along.z, g = edge1 * across.y + edge2 * across.z;
  const Real sheared = law.shear * area * dot(f, g);
  const Vec3 p = fiber_stress(f, law.rest_along, law.stiffness * area, law.amplification) + g * sheared;
  const Vec3 q = fiber_stress(g, law.rest_across, law.stiffness * area, law.amplification) + f * sheared;
  return {{p * -along.x - q * across.x, p * -along.y - q * across.y, p * -along.z - q * across.z}};
}
/// Forces of add_skin_area at all three corners.
TURGOR_HD inline CornerForces skin_area_forces(Vec3 edge1, Vec3 edge2, Real rest_area, Real stiffness,
                                               Real amplification) {
  const Vec3 n = cross(edge1, edge2);
  const Real twice_area = square_root(dot(n, n)), change = Real(0.5) * twice_area - rest_area;
  const bool degenerate = !(twice_area > Real(1e-6) * rest_area);
  const Real growth = positive(change / nonzero(rest_area));
  const Real k = degenerate ? 0 : stiffness * (1 + amplification * growth);
  const Vec3 u = n * (Real(-0.5) * k * change / nonzero(twice_area));
  return {{cross(edge1 - edge2, u), cross(edge2, u), cross(-edge1, u)}};
}

/// Newton step of one node in implicit Euler.
///   (I + c H) Δx = (y − x) + c f,  c = h² w      `to_inertial` = y − x; a fixed node (c = 0) stays
TURGOR_HD inline Vec3 newton_step(const NodeSystem& s, Vec3 to_inertial, Real c) {
  const Real a = 1 + c * s.xx, d = 1 + c * s.yy, f = 1 + c * s.zz, b = c * s.xy, e = c * s.xz, g = c * s.yz;
  const Vec3 r = to_inertial + s.f * c;
  const Real m00 = d * f - g * g, m01 = e * g - b * f, m02 = b * g - e * d;
  const Real m11 = a * f - e * e, m12 = e * b - a * g, m22 = a * d - b * b;
  const Real inverse_determinant = 1 / (a * m00 + b * m01 + e * m02);
  return Vec3{m00 * r.x + m01 * r.y + m02 * r.z, m01 * r.x + m11 * r.y + m12 * r.z,
              m02 * r.x + m12 * r.y + m22 * r.z} *
         inverse_determinant;
}

// ---------------------------------------------------------------- rest lengths of skin, both solvers

/// Rest stretch r of fibers (1 in the CT) such that they have the tension T in the CT. r is the root of
///   K (1 − r) (1 + β (1 − r)/r) = T
inline Real fiber_rest(double tension, const SkinParams& skin) {
  TURGOR_CHECK(skin.stiffness > 0, "skin with tension has a stiffness");
  const double t = tension / skin.stiffness, half = 1 + t;
  return Real(1 - 2 * t / (half + std::sqrt(half * half + 4 * (skin.amplification - 1) * t)));
}
/// Rest area over the area in the CT, r, for the mean T of both tensions. With s = (1 − r)/r, s is the root
/// of
///   K s (1 + β s) = T
inline Real rest_area_ratio(const SkinParams& skin) {
  if (skin.law == SkinLaw::kExponential) return 1;
  const double t = 0.5 * (skin.tension_along + skin.tension_across) / skin.stiffness;
  return Real(1 / (1 + 2 * t / (1 + std::sqrt(1 + 4 * skin.amplification * t))));
}
inline FiberLaw fiber_law(const SkinParams& skin) {
  if (skin.law == SkinLaw::kExponential) return {};  // the stretch of the CT follows from another law
  return {.rest_along = fiber_rest(skin.tension_along, skin),
          .rest_across = fiber_rest(skin.tension_across, skin),
          .stiffness = Real(skin.stiffness),
          .shear = Real(skin.shear),
          .amplification = Real(skin.amplification)};
}

}  // namespace turgor::lattice
