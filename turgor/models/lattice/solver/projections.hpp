// Projections of one edge or tetrahedron, for CPU lanes and GPU threads. Then those of runs whose corners are
// contiguous in memory, for CPU lanes. No two elements of a run share a node.
#pragma once

#include "turgor/models/lattice/mechanics/element_energies.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

/// Stiffness of an edge between nodes with these root stiffnesses; 0 if it is cut. `bits`: Cuts::cut of its
/// lower end.
TURGOR_HD inline Real edge_stiffness(Real root_a, Real root_b, std::uint8_t bits, int family) {
  return is_cut(bits, family) ? 0 : root_a * root_b;
}

/// Projects an edge between displacements a and b. Formula: project_spring.
[[gnu::always_inline]] TURGOR_HD inline void project_edge(Vec3& a, Vec3& b, Real wa, Real wb, Vec3 edge,
                                                          Real rest, Real stiffness) {
  const Vec3 d = edge + (b - a);
  const Real s = project_spring(d, rest, stiffness, wa, wb);
  a += d * (s * wa), b -= d * (s * wb);
}

/// Rest edges of a tetrahedron from its first corner to its others [m].
struct TetRest {
  Vec3 e1, e2, e3;
};
/// Projects a tetrahedron with displacements a to d and inverse masses wa to wd. Formula: project_volume.
[[gnu::always_inline]] TURGOR_HD inline void project_tet(Vec3& a, Vec3& b, Vec3& c, Vec3& d, Real wa, Real wb,
                                                         Real wc, Real wd, const TetRest& rest,
                                                         Real rest_volume, Real stiffness) {
  const Vec3 e1 = rest.e1 + (b - a), e2 = rest.e2 + (c - a), e3 = rest.e3 + (d - a);
  const VolumeGradients g = volume_gradients(e1, e2, e3);
  const Real s = project_volume(e1, g, rest_volume, stiffness, wa, wb, wc, wd);
  a -= (g.g1 + g.g2 + g.g3) * (s * wa);
  b += g.g1 * (s * wb), c += g.g2 * (s * wc), d += g.g3 * (s * wd);
}

/// Corrections of a skin triangle with displacements u and rest edges from its first corner. Formula:
/// project_skin.
TURGOR_HD inline SkinShift project_skin_triangle(const Vec3 (&u)[3], Vec3 edge1, Vec3 edge2, Vec3 w,
                                                 Real rest_area, Real stiffness, Real amplification) {
  return project_skin(Vec3{}, edge1 + (u[1] - u[0]), edge2 + (u[2] - u[0]), w, rest_area, stiffness,
                      amplification);
}

/// Edge of a tetrahedron: its lower end (a corner of the tetrahedron) and its family.
struct TetEdge {
  int corner = 0, family = 0;
};
constexpr std::array<TetEdge, 6> tet_edges(const std::array<Int3, 4>& tet) {
  std::array<TetEdge, 6> edges;
  std::size_t e = 0;
  for (std::size_t p = 0; p < 4; p++)
    for (std::size_t q = p + 1; q < 4; q++, e++) {
      const Int3 offset = tet[q] - tet[p];
      const bool forward = family_of(offset) >= 0;
      edges[e] = {int(forward ? p : q), family_of(forward ? offset : -offset)};
    }
  return edges;
}
/// 1 if an edge of a tetrahedron is cut, else 0. `bits_of(corner)`: Cuts::cut of a corner of the tetrahedron.
template <class BitsOf>
[[gnu::always_inline]] TURGOR_HD inline int any_cut(const std::array<TetEdge, 6>& edges,
                                                    const BitsOf& bits_of) {
  int any = 0;
  TURGOR_UNROLL
  for (std::size_t e = 0; e < 6; e++) any |= is_cut(bits_of(edges[e].corner), edges[e].family);
  return any;
}

/// Pointers to the nodes of a run that begins at slot `first`.
struct NodeRun {
  Real* __restrict x;
  Real* __restrict y;
  Real* __restrict z;
  const Real* __restrict w;
  const Real* __restrict root;

  NodeRun(const NodeArrays& n, int first)
      : x(n.ux + first), y(n.uy + first), z(n.uz + first), w(n.w + first), root(n.root + first) {}
  Vec3 u(int i) const { return {x[i], y[i], z[i]}; }
  void set(int i, Vec3 u) const { x[i] = u.x, y[i] = u.y, z[i] = u.z; }
};

/// Projects kWidth edges of one family between two runs of nodes; a and b are the first slots.
template <bool kWithCuts, int kWidth>
void project_edges(const NodeArrays& nodes, int first, int other, Vec3 edge, Real rest, int family) {
  const NodeRun a(nodes, first), b(nodes, other);
  const std::uint8_t* __restrict cut = nodes.cut + first;
  const Vec3 rest_edge = edge;  // local copy, so that stores cannot alias it
  TURGOR_LANES
  for (int i = 0; i < kWidth; i++) {
    const Real stiffness = edge_stiffness(a.root[i], b.root[i], kWithCuts ? cut[i] : 0, family);
    Vec3 ua = a.u(i), ub = b.u(i);
    project_edge(ua, ub, a.w[i], b.w[i], rest_edge, rest, stiffness);
    a.set(i, ua), b.set(i, ub);
  }
}

/// One of the six tetrahedra of a cell with one parity of i, relative to the slot of the cell's lowest node.
struct CellTet {
  int offset[4];  // of the corners [slots]
  TetRest rest;
  std::array<TetEdge, 6> edge;
};
CellTet cell_tet(const Lattice& lattice, int parity, const std::array<Int3, 4>& tet);

/// Projects one tetrahedron of each of `count` cells in a row.
template <bool kWithCuts>
void project_volumes(const NodeArrays& n, const CellTet& tet, int first, int count, Real rest_volume) {
  const NodeRun a(n, first + tet.offset[0]), b(n, first + tet.offset[1]), c(n, first + tet.offset[2]),
      d(n, first + tet.offset[3]);
  const std::uint8_t* __restrict cut = n.cut + first;
  const TetRest rest = tet.rest;  // local copy, so that stores cannot alias it
  TURGOR_LANES
  for (int i = 0; i < count; i++) {
    // stiffness, 0 for cut tetrahedra
    Real stiffness = tet_stiffness(a.root[i], d.root[i], b.root[i], c.root[i], d.root[i]);
    if constexpr (kWithCuts)
      stiffness = any_cut(tet.edge, [&](int corner) { return cut[tet.offset[corner] + i]; }) ? 0 : stiffness;
    Vec3 ua = a.u(i), ub = b.u(i), uc = c.u(i), ud = d.u(i);
    project_tet(ua, ub, uc, ud, a.w[i], b.w[i], c.w[i], d.w[i], rest, rest_volume, stiffness);
    a.set(i, ua), b.set(i, ub), c.set(i, uc), d.set(i, ud);
  }
}

}  // namespace turgor::lattice
