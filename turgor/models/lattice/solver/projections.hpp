// Projections of runs of edges and tetrahedra whose corners are contiguous in memory: sixteen at once in CPU
// lanes, or one per GPU thread. No two elements of a call share a node.
#pragma once

#include "turgor/models/lattice/mechanics/element_energies.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

/// Projects kWidth edges of one family between two runs of nodes; a and b are the first slots. Formula:
/// project_spring.
template <bool kWithCuts, int kWidth>
TURGOR_HD inline void project_edges(const NodeArrays& n, int a, int b, Vec3 edge, Real rest, int family) {
  Real* __restrict ax = n.ux + a, * __restrict ay = n.uy + a, * __restrict az = n.uz + a;
  Real* __restrict bx = n.ux + b, * __restrict by = n.uy + b, * __restrict bz = n.uz + b;
  const Real* __restrict wa = n.w + a, * __restrict wb = n.w + b, * __restrict ra = n.root + a, * __restrict rb = n.root + b;
  const std::uint8_t* __restrict cut = n.cut + a;
  const auto [ex, ey, ez] = edge;
  TURGOR_LANES
  for (int i = 0; i < kWidth; i++) {
    const Vec3 d{ex + (bx[i] - ax[i]), ey + (by[i] - ay[i]), ez + (bz[i] - az[i])};
    // stiffness, 0 for cut edges
    Real stiffness = ra[i] * rb[i];
    if constexpr (kWithCuts) stiffness = cut[i] >> family & 1 ? 0 : stiffness;
    // corrections
    const Real s = project_spring(d, rest, stiffness, wa[i], wb[i]);
    const Real sa = s * wa[i], sb = s * wb[i];
    ax[i] += sa * d.x, ay[i] += sa * d.y, az[i] += sa * d.z;
    bx[i] -= sb * d.x, by[i] -= sb * d.y, bz[i] -= sb * d.z;
  }
}

/// One of the six tetrahedra of a cell with one parity of i, relative to the slot of the cell's lowest node.
struct CellTet {
  int offset[4];    // of the corners [slots]
  Vec3 e1, e2, e3;  // rest edges from the first corner [m]
  struct {
    int corner, family;
  } edge[6];  // lower end and family
};
CellTet cell_tet(const Lattice& lattice, int parity, const std::array<Int3, 4>& tet);

/// Projects one tetrahedron of each of `count` cells in a row. Formula: project_volume.
template <bool kWithCuts>
TURGOR_HD inline void project_volumes(const NodeArrays& n, const CellTet& tet, int first, int count,
                                      Real rest_volume) {
  // corners
  const int a = first + tet.offset[0], b = first + tet.offset[1], c = first + tet.offset[2],
            d = first + tet.offset[3];
  Real* __restrict ax = n.ux + a, * __restrict ay = n.uy + a, * __restrict az = n.uz + a;
  Real* __restrict bx = n.ux + b, * __restrict by = n.uy + b, * __restrict bz = n.uz + b;
  Real* __restrict cx = n.ux + c, * __restrict cy = n.uy + c, * __restrict cz = n.uz + c;
  Real* __restrict dx = n.ux + d, * __restrict dy = n.uy + d, * __restrict dz = n.uz + d;
  const Real* __restrict wa = n.w + a, * __restrict wb = n.w + b, * __restrict wc = n.w + c, * __restrict wd = n.w + d;
  const Real* __restrict ra = n.root + a, * __restrict rb = n.root + b, * __restrict rc = n.root + c, * __restrict rd = n.root + d;
  const auto [e1x, e1y, e1z] = tet.e1;
  const auto [e2x, e2y, e2z] = tet.e2;
  const auto [e3x, e3y, e3z] = tet.e3;
  // projections
  TURGOR_LANES
  for (int i = 0; i < count; i++) {
    const Vec3 e1{e1x + (bx[i] - ax[i]), e1y + (by[i] - ay[i]), e1z + (bz[i] - az[i])};
    const Vec3 e2{e2x + (cx[i] - ax[i]), e2y + (cy[i] - ay[i]), e2z + (cz[i] - az[i])};
    const Vec3 e3{e3x + (dx[i] - ax[i]), e3y + (dy[i] - ay[i]), e3z + (dz[i] - az[i])};
    Real stiffness = tet_stiffness(ra[i], rd[i], rb[i], rc[i], rd[i]);
    if constexpr (kWithCuts) {
      int cut = 0;
      for (const auto& edge : tet.edge) cut |= n.cut[first + tet.offset[edge.corner] + i] >> edge.family & 1;
      stiffness = cut ? 0 : stiffness;
    }
    const VolumeGradients g = volume_gradients(e1, e2, e3);
    const Real s = project_volume(e1, g, rest_volume, stiffness, wa[i], wb[i], wc[i], wd[i]);
    const Real sa = -s * wa[i], sb = s * wb[i], sc = s * wc[i], sd = s * wd[i];
    const Vec3 g0 = g.g1 + g.g2 + g.g3;
    ax[i] += sa * g0.x, ay[i] += sa * g0.y, az[i] += sa * g0.z;
    bx[i] += sb * g.g1.x, by[i] += sb * g.g1.y, bz[i] += sb * g.g1.z;
    cx[i] += sc * g.g2.x, cy[i] += sc * g.g2.y, cz[i] += sc * g.g2.z;
    dx[i] += sd * g.g3.x, dy[i] += sd * g.g3.y, dz[i] += sd * g.g3.z;
  }
}

}  // namespace turgor::lattice
