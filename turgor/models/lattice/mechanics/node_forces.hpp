// What the springs, the tetrahedra and the cells around one node ask of it: the body of loops over lanes of a
// CPU, and of a thread of a GPU. What a blade went through, the caller knows, of many nodes at once or of
// one.
#pragma once

#include <type_traits>
#include <utility>

#include "turgor/models/lattice/mechanics/cells.hpp"
#include "turgor/models/lattice/model/neighbors.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

/// Calls f(t) for every one of kTetsAround. For nvcc t is a constant, so that what is looked up with it stays
/// in registers; the CPU's compilers make vectors of a loop, and not of calls.
template <class F>
[[gnu::always_inline]] TURGOR_HD inline void for_each_tet_around(const F& f) {
#ifdef __CUDACC__
  [&]<std::size_t... kTets>(std::index_sequence<kTets...>) {
    (f(std::integral_constant<std::size_t, kTets>{}), ...);
  }
  (std::make_index_sequence<kTetsAround.size()>{});
#else
  TURGOR_UNROLL
  for (std::size_t t = 0; t < kTetsAround.size(); t++) f(t);
#endif
}
template <std::size_t kTet>
TURGOR_HD constexpr TetAround tet_around(std::integral_constant<std::size_t, kTet>) {
  constexpr TetAround around = kTetsAround[kTet];
  return around;
}
constexpr const TetAround& tet_around(std::size_t t) { return kTetsAround[t]; }

/// Springs and volumes around node a. Distances to the neighbours are computed once and serve both.
/// `spring(e)` and `tet(t)`: 1 where no blade went through, or 0; t as for_each_tet_around has it.
template <bool kWithVolumes, class Spring, class Tet>
[[gnu::always_inline]] TURGOR_HD inline NodeSystem springs_around(const NodeArrays& n,
                                                                  const Neighbors& around, Real rest_volume,
                                                                  Real volume_scale, int a,
                                                                  const Spring& spring, const Tet& tet) {
  NodeSystem s;
  Vec3 d[kNeighborCount];
  Real root[kNeighborCount];
  TURGOR_UNROLL
  for (int e = 0; e < kNeighborCount; e++) {
    const int b = a + around.offset[e];
    d[e] = around.edge[e] + (n.u(b) - n.u(a));
    root[e] = n.root[b];
    add_spring(s, d[e], around.rest[e], around.scale[e] * n.root[a] * root[e] * spring(e));
  }
  if constexpr (kWithVolumes) {
    for_each_tet_around([&](auto t) {
      const TetAround& at = tet_around(t);
      const auto root_of = [&](int neighbor) { return neighbor < 0 ? n.root[a] : root[neighbor]; };
      Real k = tet_stiffness(root_of(at.far[0]), root_of(at.far[1]), root[at.corner[0]], root[at.corner[1]],
                             root[at.corner[2]]);
      k *= volume_scale / rest_volume;
      k *= tet(t);
      const VolumeGradients g = volume_gradients(d[at.corner[0]], d[at.corner[1]], d[at.corner[2]]);
      const Real sixth = Real(1) / 6;
      add_volume(s, (g.g1 + g.g2 + g.g3) * -sixth, k, dot(d[at.corner[0]], g.g1) * sixth - rest_volume);
    });
  }
  return s;
}

/// The eight cells around node a, which is corner n of cell n; `young(n)`: of what is whole [Pa].
template <class Young>
[[gnu::always_inline]] TURGOR_HD inline NodeSystem cells_around(const NodeArrays& n, const SolidLaw& law,
                                                                const NodeBlock& block, int a,
                                                                const Young& young) {
  NodeSystem s;
  Vec3 u[kBlockNodes];
  TURGOR_UNROLL
  for (int b = 0; b < kBlockNodes; b++) u[b] = n.u(a + block.offset[b]) - n.u(a);
  TURGOR_UNROLL
  for (int at = 0; at < kCellCorners; at++) {
    Vec3 d[kCellCorners];
    TURGOR_UNROLL
    for (int c = 0; c < kCellCorners; c++) d[c] = u[block_index(cell_corner(c) - cell_corner(at))];
    add_cell(s, cell_gradient(d, at, law.slope), at, law, young(at));
  }
  return s;
}

/// The edges of node a that no whole cell holds; `stiffness(e)`: 0 for others [N/m].
template <class Stiffness>
[[gnu::always_inline]] TURGOR_HD inline void add_loose_edges(NodeSystem& s, const NodeArrays& n,
                                                             const Neighbors& around, int a,
                                                             const Stiffness& stiffness) {
  TURGOR_UNROLL
  for (int e = 0; e < kNeighborCount; e++) {
    const Real k = stiffness(e);
    const Real there = k > 0 ? Real(1) : Real(0);  // slots without a node lie still, wherever this one goes
    add_spring(s, around.edge[e] + (n.u(a + around.offset[e]) - n.u(a)) * there, around.rest[e], k);
  }
}

}  // namespace turgor::lattice
