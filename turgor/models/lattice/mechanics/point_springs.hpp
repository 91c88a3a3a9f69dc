// Springs on points embedded in cells. The displacement of a point is trilinear in the eight corners of its
// cell, or of its fragment of a cut cell, so that a point follows the tissue on its side of a wound. Stitches
// and other devices inside the tissue act through these springs. [Sifakis et al. 2007]
#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "turgor/models/lattice/mechanics/element_energies.hpp"
#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

/// Point embedded in a cell. A weight is that of a corner in the displacement of the point; their sum is 1.
struct EmbeddedPoint {
  int cell = 0;                 // slot of the cell's lowest node
  std::array<int, 8> corner{};  // as in CutCellElement
  std::array<Real, 8> weight{};

  friend bool operator==(const EmbeddedPoint&, const EmbeddedPoint&) = default;
};

/// Symmetric stiffness matrix [N/m], positive semidefinite.
struct PointStiffness {
  Real xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;

  Vec3 operator*(Vec3 d) const {
    return {xx * d.x + xy * d.y + xz * d.z, xy * d.x + yy * d.y + yz * d.z, xz * d.x + yz * d.y + zz * d.z};
  }
};
inline PointStiffness isotropic_stiffness(Real k) { return {.xx = k, .yy = k, .zz = k}; }
/// along · n nᵀ + across · (I − n nᵀ) for a unit vector n.
inline PointStiffness axial_stiffness(Vec3 n, Real along, Real across) {
  const Real k = along - across;
  return {across + k * n.x * n.x, across + k * n.y * n.y, across + k * n.z * n.z,
          k * n.x * n.y,          k * n.x * n.z,          k * n.y * n.z};
}

/// Share of a spring in a stiffness that couples it with the springs after it, as a thread couples the points
/// of a stitch: E = ½ k (Σ gₚ·uₚ)² for small displacements. Sweeps use the stiffness of every spring by
/// itself; the coarse correction uses k (coupled_points.hpp).
struct PointCoupling {
  Vec3 direction;      // g of this point in the undeformed body [1]
  int count = 0;       // in the first of the coupled springs: their number; 0 in the others, or alone
  Real stiffness = 0;  // in the first one: k at present [N/m]
};

/// Spring at a point with displacement u, d = u − target.
///   E = ½ dᵀ K d − f₀·u
///   F = f₀ − K d
struct PointSpring {
  EmbeddedPoint at;
  Vec3 target;               // displacement at which K has no force [m]
  PointStiffness stiffness;  // K [N/m]
  Vec3 force;                // f₀, constant during a sweep [N]
  PointCoupling coupling;    // with the springs after it; part of K, not added to it
};

/// Corner of a point with a spring.
struct PointSpringTerm {
  int corner = 0;  // as in CutCellElement
  int spring = 0;  // index into PointSprings::all
  Real weight = 0;
};

/// Springs of a step. Between sweeps `refresh` may change target, stiffness and force of every spring, and
/// the stiffness of couplings, but not the points: springs of different points are then coupled without
/// dependence on the order of nodes.
struct PointSprings {
  std::vector<PointSpring> all;
  std::vector<PointSpringTerm> terms;         // corners ascend; see make_terms
  std::function<void(const State&)> refresh;  // called before each sweep and after the last; may be empty
  bool settled = false;                       // true: the rows around may sleep
};
/// Lists the corners of all points. Call it after a change of the points.
void make_terms(PointSprings& springs);
/// Terms with corners in [corner, corner + count); none for null.
std::span<const PointSpringTerm> terms_of(const PointSprings* springs, int corner, int count);

/// Displacement of a point [m]. `u(corner)`: displacement of a corner.
template <class U>
Vec3 displacement(const EmbeddedPoint& point, const U& u) {
  Vec3 sum;
  for (std::size_t c = 0; c < 8; c++)
    if (point.weight[c] != 0) sum += u(point.corner[c]) * point.weight[c];
  return sum;
}
Vec3 displacement(const EmbeddedPoint& point, const Motion& motion);

/// Force F on the tissue at a displacement u [N].
inline Vec3 spring_force(const PointSpring& spring, Vec3 u) {
  return spring.force - spring.stiffness * (u - spring.target);
}
double spring_energy(const PointSpring& spring, Vec3 u);

/// Adds the springs of one corner to its system: w F and w² K.
template <class U>
void add_point_springs(NodeSystem& s, const PointSprings& springs, std::span<const PointSpringTerm> terms,
                       const U& u) {
  for (const PointSpringTerm& term : terms) {
    const PointSpring& spring = springs.all[std::size_t(term.spring)];
    const PointStiffness& k = spring.stiffness;
    const Real w = term.weight, w2 = w * w;
    s.f += spring_force(spring, displacement(spring.at, u)) * w;
    s.xx += w2 * k.xx, s.yy += w2 * k.yy, s.zz += w2 * k.zz;
    s.xy += w2 * k.xy, s.xz += w2 * k.xz, s.yz += w2 * k.yz;
  }
}

}  // namespace turgor::lattice
