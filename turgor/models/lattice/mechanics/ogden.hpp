// Ogden law of one term for solid cells: brain and other tissue that stiffens by its stretches themselves.
// Principal stretches come from a Jacobi eigenvalue iteration without branches, so that it runs in SIMD
// lanes. A cell costs several times a neo-Hookean one.
#pragma once

#include "turgor/models/lattice/mechanics/solid_laws.hpp"

namespace turgor::lattice {

/// e^x − 1 for x from −80 to 80, accurate at 0.
TURGOR_HD inline Real lane_expm1(Real x) {
  const Real turns = x * Real(1.44269504), half = turns < 0 ? Real(-0.5) : Real(0.5);
  const auto n = std::int32_t(turns + half);
  const Real f = (x - Real(n) * Real(0.693145752)) - Real(n) * Real(1.42860677e-6);
  const Real p =
      f * (1 + f * (Real(0.5) +
                    f * (Real(1) / 6 + f * (Real(1) / 24 + f * (Real(1) / 120 + f * (Real(1) / 720))))));
  const Real power = std::bit_cast<Real>((n + 127) << 23);
  return p * power + (power - 1);
}
/// ln(1 + x) for x above −1, accurate at 0: ln m with s = (m − 1)/(m + 1) and the exponent apart.
TURGOR_HD inline Real lane_log1p(Real x) {
  const Real y = 1 + x;
  const std::int32_t bits = std::bit_cast<std::int32_t>(y);
  const std::int32_t n = (bits - std::int32_t(0x3f3504f3)) >> 23;  // y = 2^n m with m from √½ to √2
  const Real m = std::bit_cast<Real>(bits - n * (1 << 23));
  const Real above = n == 0 ? x : m - 1;
  const Real s = above / (2 + above), s2 = s * s;
  const Real series = 2 + s2 * (Real(2) / 3 + s2 * (Real(2) / 5 + s2 * (Real(2) / 7 + s2 * (Real(2) / 9))));
  return s * series + Real(n) * Real(0.693147181);
}

/// Eigenvalues and eigenvectors (columns) of a symmetric matrix.
struct LaneEigen {
  Real xx, yy, zz, xy, xz, yz;  // of the matrix; after the iteration the eigenvalues xx, yy, zz
  Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
};
/// One Jacobi rotation: p, q diagonal, o their off-diagonal entry, a and b the other two; v, w their vectors.
[[gnu::always_inline]] TURGOR_HD inline void jacobi_rotation(Real& p, Real& q, Real& o, Real& a, Real& b,
                                                             Vec3& v, Vec3& w) {
  const Real difference = q - p, twice = 2 * o;
  const Real size =
      (difference < 0 ? -difference : difference) + square_root(difference * difference + twice * twice);
  const Real t = (difference < 0 ? -twice : twice) / nonzero(size);
  const Real c = 1 / square_root(1 + t * t), s = t * c;
  p -= t * o, q += t * o, o = 0;
  const Real a_before = a, b_before = b;
  a = c * a_before - s * b_before, b = s * a_before + c * b_before;
  const Vec3 v_before = v, w_before = w;
  v = v_before * c - w_before * s, w = v_before * s + w_before * c;
}
[[gnu::always_inline]] TURGOR_HD inline void solve_eigen(LaneEigen& e) {
  TURGOR_UNROLL
  for (int sweep = 0; sweep < 4; sweep++) {
    jacobi_rotation(e.xx, e.yy, e.xy, e.xz, e.yz, e.x, e.y);
    jacobi_rotation(e.xx, e.zz, e.xz, e.xy, e.yz, e.x, e.z);
    jacobi_rotation(e.yy, e.zz, e.yz, e.xy, e.xz, e.y, e.z);
  }
}

/// One term of Ogden's law [Ogden 1972], isochoric part and volume apart. λᵢ: principal stretches, λ̄ᵢ =
/// J^(−1/3) λᵢ:
///   Ψ = 2µ/α² Σ (λ̄ᵢ^α − 1) + κ/2 (J − 1)²
///   Wᵢ = ∂Ψ/∂ln λᵢ = 2µ/α (λ̄ᵢ^α − mean),   P = Σ Wᵢ/λᵢ nᵢ Nᵢᵀ + κ (J − 1) cof F
/// Small strains see µ and κ. The Hessian is that of the principal stretches with its negative parts left
/// out: ψᵢ = Wᵢ/λᵢ; twists have (ψᵢ + ψⱼ)/(λᵢ + λⱼ), shears (ψᵢ − ψⱼ)/(λᵢ − λⱼ). [Smith, de Goes, Kim 2019]
struct OgdenLaw {
  static constexpr bool kHasFibers = false;
  struct Principal {
    Vec3 material[3], spatial[3];  // Nᵢ, F Nᵢ = λᵢ nᵢ
    Real stretch2[3];              // λᵢ² [1]
    Real w[3];                     // V Wᵢ [J]
    Real slope[3];                 // V 2µ λ̄ᵢ^α [J]
    Real growth;                   // J − 1
    Vec3 dcof_x, dcof_y, dcof_z;   // columns of cof F − 1
  };
  [[gnu::always_inline]] TURGOR_HD static Principal principal(Vec3 ux, Vec3 uy, Vec3 uz,
                                                              const CellModuli& m) {
    const CellCofactor c = cell_cofactor(ux, uy, uz);
    // Fᵀ F − 1
    LaneEigen e{.xx = 2 * ux.x + dot(ux, ux),
                .yy = 2 * uy.y + dot(uy, uy),
                .zz = 2 * uz.z + dot(uz, uz),
                .xy = ux.y + uy.x + dot(ux, uy),
                .xz = ux.z + uz.x + dot(ux, uz),
                .yz = uy.z + uz.y + dot(uy, uz)};
    solve_eigen(e);
    Principal p;
    p.growth = c.growth, p.dcof_x = c.x, p.dcof_y = c.y, p.dcof_z = c.z;
    const Vec3 axes[3] = {e.x, e.y, e.z};
    const Real above[3] = {e.xx, e.yy, e.zz};
    // λ̄ᵢ^α − 1
    const bool regular = 1 + c.growth > kLeastGrowth;
    const Real volume = lane_log1p(regular ? c.growth : kLeastGrowth - 1) * (Real(1) / 3);
    const Real inverse_alpha = 1 / (m.stiffening != 0 ? m.stiffening : 1);  // 0: a cell of another law
    Real power[3], mean = 0;
    TURGOR_UNROLL
    for (int i = 0; i < 3; i++) {
      const Real bounded = above[i] > Real(-0.9999) ? above[i] : Real(-0.9999);
      const Real x = m.stiffening * (Real(0.5) * lane_log1p(bounded) - volume);
      power[i] = lane_expm1(x < kLargestExponent ? (x > -kLargestExponent ? x : -kLargestExponent)
                                                 : kLargestExponent);
      mean += power[i] * (Real(1) / 3);
      p.slope[i] = x < kLargestExponent ? 2 * m.shear * (1 + power[i]) : 0;
      p.stretch2[i] = 1 + bounded;
      p.material[i] = axes[i];
      p.spatial[i] = axes[i] + ux * axes[i].x + uy * axes[i].y + uz * axes[i].z;
    }
    TURGOR_UNROLL
    for (int i = 0; i < 3; i++)
      p.w[i] = 2 * m.shear * inverse_alpha * (power[i] - (regular ? mean : Real(-1)));
    return p;
  }

  [[gnu::always_inline]] TURGOR_HD static Real add(NodeSystem& s, const CellGradient& u, Vec3 g,
                                                   const CellModuli& m) {
    const Principal p = principal(u.x, u.y, u.z, m);
    const Vec3 cg = g + p.dcof_x * g.x + p.dcof_y * g.y + p.dcof_z * g.z;
    // force, and components in the principal axes
    Real at[3], stretch[3], psi[3], positive_slope[3];
    Vec3 axis[3], f = cg * (m.bulk * p.growth);
    TURGOR_UNROLL
    for (int i = 0; i < 3; i++) {
      at[i] = dot(p.material[i], g);
      const Real inverse2 = 1 / p.stretch2[i];
      stretch[i] = square_root(p.stretch2[i]);
      axis[i] = p.spatial[i] * (stretch[i] * inverse2);
      psi[i] = p.w[i] * stretch[i] * inverse2;
      f += p.spatial[i] * (p.w[i] * inverse2 * at[i]);
      positive_slope[i] = p.w[i] < 0 ? -p.w[i] : 0;
    }
    s.f -= f;
    add_outer(s, cg, m.bulk);
    // stretches: Σ slopeₘ (eₘ − 1/3)(eₘ − 1/3)ᵀ in the logarithms
    Vec3 sum;
    Vec3 along[3];
    TURGOR_UNROLL
    for (int i = 0; i < 3; i++) {
      along[i] = axis[i] * (at[i] / stretch[i]);
      sum += along[i] * (Real(1) / 3);
    }
    TURGOR_UNROLL
    for (int i = 0; i < 3; i++) {
      add_outer(s, along[i] - sum, p.slope[i]);
      add_outer(s, along[i], positive_slope[i]);
    }
    // twists and shears of pairs of axes
    TURGOR_UNROLL
    for (int i = 0; i < 3; i++) {
      const int a = i, b = (i + 1) % 3;
      const Real twist = (psi[a] + psi[b]) / (stretch[a] + stretch[b]);
      const Real gap = stretch[a] - stretch[b];
      const bool apart = gap * gap > Real(1e-4);
      const Real limit = Real(0.5) * (p.slope[a] / p.stretch2[a] + p.slope[b] / p.stretch2[b]) -
                         Real(0.5) * (p.w[a] / p.stretch2[a] + p.w[b] / p.stretch2[b]);
      const Real shear = apart ? (psi[a] - psi[b]) / (apart ? gap : 1) : limit;
      add_outer(s, axis[a] * at[b] - axis[b] * at[a], Real(0.5) * positive(twist));
      add_outer(s, axis[a] * at[b] + axis[b] * at[a], Real(0.5) * positive(shear));
    }
    return 0;
  }

  [[gnu::always_inline]] TURGOR_HD static CellPiola piola(Vec3 ux, Vec3 uy, Vec3 uz, const CellModuli& m) {
    const Principal p = principal(ux, uy, uz, m);
    const Real k = m.bulk * p.growth;
    CellPiola out{p.dcof_x * k + Vec3{k, 0, 0}, p.dcof_y * k + Vec3{0, k, 0}, p.dcof_z * k + Vec3{0, 0, k}};
    TURGOR_UNROLL
    for (int i = 0; i < 3; i++) {
      const Vec3 force = p.spatial[i] * (p.w[i] / p.stretch2[i]);
      out.x += force * p.material[i].x, out.y += force * p.material[i].y, out.z += force * p.material[i].z;
    }
    return out;
  }
};

}  // namespace turgor::lattice
