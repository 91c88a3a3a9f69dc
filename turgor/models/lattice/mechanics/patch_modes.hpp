// Derivatives of the displacement of a cell along a direction, at the four integration points of its patch of
// skin. The points are c ± p ± q. The displacement is trilinear, so that a derivative at these points is
//   ∂u = ∂u₀ ± ∂u_p ± ∂u_q ± ± ∂u_pq
// with four vectors that are linear in the differences of the corners. This form costs half of four
// gradients.
#pragma once

#include "turgor/models/lattice/mechanics/solid.hpp"
#include "turgor/models/lattice/model/model.hpp"

namespace turgor::lattice {

/// Integration points of a patch, exact for the gradient in the cell. One point would leave modes of the skin
/// without energy, and skin is stiffer than the tissue below.
constexpr int kPatchPoints = 4;
/// Integration point, in half cells from the center of the cell.
TURGOR_HD inline Vec3 patch_point(const SkinPatch& p, int n) {
  return p.point + (n & 1 ? p.reach1 : -p.reach1) + (n & 2 ? p.reach2 : -p.reach2);
}

/// Symmetric products of the coordinates of two vectors: yz, xz and xy.
[[gnu::always_inline]] TURGOR_HD inline Vec3 symmetric_products(Vec3 a, Vec3 b) {
  return {a.y * b.z + a.z * b.y, a.x * b.z + a.z * b.x, a.x * b.y + a.y * b.x};
}

/// A quantity at the integration points: mean, and the parts that change sign with p, with q and with both.
template <class T>
struct AtPatchPoints {
  T mean, p, q, pq;

  [[gnu::always_inline]] TURGOR_HD T at(int n) const {
    const T along_q = n & 2 ? mean + q : mean - q, change = n & 2 ? p + pq : p - pq;
    return n & 1 ? along_q + change : along_q - change;
  }
};

/// Products yz, xz and xy of the coordinates of the integration points.
[[gnu::always_inline]] TURGOR_HD inline AtPatchPoints<Vec3> point_products(const SkinPatch& patch) {
  const Vec3 c = patch.point, p = patch.reach1, q = patch.reach2;
  return {{c.y * c.z + p.y * p.z + q.y * q.z, c.x * c.z + p.x * p.z + q.x * q.z,
           c.x * c.y + p.x * p.y + q.x * q.y},
          symmetric_products(c, p),
          symmetric_products(c, q),
          symmetric_products(p, q)};
}

/// Factors of the differences of corners in the derivative along a direction a:
///   ∂u = a·(X, Y, Z) + t·(YZ, XZ, XY) + w XYZ,  t = (a_y z + a_z y, …),  w = a·(yz, xz, xy)
/// X to XYZ: CornerSums and CellTwists.
struct PatchDerivative {
  Vec3 a;                                   // direction times the slope of shape functions [1/m]
  Vec3 twist_mean, twist_p, twist_q;        // t [1/m]
  Real warp_mean, warp_p, warp_q, warp_pq;  // w [1/m]
};
[[gnu::always_inline]] TURGOR_HD inline PatchDerivative patch_derivative(const SkinPatch& patch,
                                                                         const AtPatchPoints<Vec3>& products,
                                                                         Vec3 direction, Vec3 slope) {
  const Vec3 a = hadamard(direction, slope);
  return {a,
          symmetric_products(a, patch.point),
          symmetric_products(a, patch.reach1),
          symmetric_products(a, patch.reach2),
          dot(a, products.mean),
          dot(a, products.p),
          dot(a, products.q),
          dot(a, products.pq)};
}

/// Derivative of the displacement. `d`: displacements of the corners relative to any one of them [m].
[[gnu::always_inline]] TURGOR_HD inline AtPatchPoints<Vec3> derivatives_of(const PatchDerivative& by,
                                                                           const CornerSums& sums,
                                                                           const CellTwists& twists) {
  const auto twisted = [&](Vec3 t, Real w) {
    return twists.yz * t.x + twists.xz * t.y + twists.xy * t.z + twists.xyz * w;
  };
  return {sums.x * by.a.x + sums.y * by.a.y + sums.z * by.a.z + twisted(by.twist_mean, by.warp_mean),
          twisted(by.twist_p, by.warp_p), twisted(by.twist_q, by.warp_q), twists.xyz * by.warp_pq};
}

/// Derivative of the shape function of a corner [1/m].
[[gnu::always_inline]] TURGOR_HD inline AtPatchPoints<Real> derivatives_of_shape(const PatchDerivative& by,
                                                                                 int corner) {
  const Int3 side = corner_sign(corner);
  const Vec3 s{Real(side.x), Real(side.y), Real(side.z)}, pairs{s.y * s.z, s.x * s.z, s.x * s.y};
  const Real all = s.x * pairs.x;
  return {dot(by.a, s) + dot(by.twist_mean, pairs) + by.warp_mean * all,
          dot(by.twist_p, pairs) + by.warp_p * all, dot(by.twist_q, pairs) + by.warp_q * all,
          by.warp_pq * all};
}

/// Sums of the values at the points times 1 and the signs of p, of q and of both.
[[gnu::always_inline]] TURGOR_HD inline AtPatchPoints<Vec3> signed_sums(Vec3 v0, Vec3 v1, Vec3 v2, Vec3 v3) {
  const Vec3 sum = v0 + v1, difference = v1 - v0, sum_q = v2 + v3, difference_q = v3 - v2;
  return {sum + sum_q, difference + difference_q, sum_q - sum, difference_q - difference};
}
/// Sum of the products with a second quantity over the points, from signed_sums.
[[gnu::always_inline]] TURGOR_HD inline Vec3 sum_of_products(const AtPatchPoints<Vec3>& sums,
                                                             const AtPatchPoints<Real>& b) {
  return sums.mean * b.mean + sums.p * b.p + sums.q * b.q + sums.pq * b.pq;
}

/// Mean of the product of two quantities over the integration points.
[[gnu::always_inline]] TURGOR_HD inline Real mean_product(const AtPatchPoints<Real>& a,
                                                          const AtPatchPoints<Real>& b) {
  return a.mean * b.mean + a.p * b.p + a.q * b.q + a.pq * b.pq;
}
/// Mean square of the difference from the mean. At each point, the square is at most three times as large.
[[gnu::always_inline]] TURGOR_HD inline Real variance(const AtPatchPoints<Vec3>& a) {
  return dot(a.p, a.p) + dot(a.q, a.q) + dot(a.pq, a.pq);
}

}  // namespace turgor::lattice
