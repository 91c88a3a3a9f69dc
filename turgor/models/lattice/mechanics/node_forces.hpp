// Forces and Hessians of springs, tetrahedra and cells around one node, and their cut states. The functions
// are loop bodies for CPU lanes and for one GPU thread. CPU loops find the cut states first, because loops
// over numbers of different sizes vectorize only four wide.
#pragma once

#include <type_traits>
#include <utility>

#include "turgor/models/lattice/mechanics/cells.hpp"
#include "turgor/models/lattice/model/neighbors.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

/// Calls f(t) for all of kIncidentTets. With nvcc t is a compile-time constant, so that table lookups stay in
/// registers. CPU compilers vectorize a loop but not such calls.
template <class F>
[[gnu::always_inline]] TURGOR_HD inline void for_each_incident_tet(const F& f) {
#ifdef __CUDACC__
  [&]<std::size_t... kTets>(std::index_sequence<kTets...>) {
    (f(std::integral_constant<std::size_t, kTets>{}), ...);
  }
  (std::make_index_sequence<kIncidentTets.size()>{});
#else
  TURGOR_UNROLL
  for (std::size_t t = 0; t < kIncidentTets.size(); t++) f(t);
#endif
}
template <std::size_t kTet>
TURGOR_HD constexpr IncidentTet incident_tet(std::integral_constant<std::size_t, kTet>) {
  constexpr IncidentTet stencil = kIncidentTets[kTet];
  return stencil;
}
constexpr const IncidentTet& incident_tet(std::size_t t) { return kIncidentTets[t]; }

/// Lower end of edge e of a node, relative to the node; that of an edge of a tetrahedron around it [slots].
TURGOR_HD inline int lower_end(const Neighbors& stencil, int e) { return e % 2 == 0 ? 0 : stencil.offset[e]; }
TURGOR_HD inline int lower_end(const Neighbors& stencil, IncidentEdge edge) {
  return edge.lower < 0 ? 0 : stencil.offset[edge.lower];
}

/// Slot of corner c of the cell whose corner `at` is node s.
TURGOR_HD inline int corner_slot(const NodeBlock& block, int s, int at, int c) {
  return s + block.offset[block_index(cell_corner(c) - cell_corner(at))];
}
/// Cut edges in the cell whose corner `at` is node s; 0 if none is cut.
[[gnu::always_inline]] TURGOR_HD inline std::uint8_t cut_edges_of_cell(const std::uint8_t* cut,
                                                                       const NodeBlock& block, int s,
                                                                       int at) {
  std::uint8_t bits = 0;
  TURGOR_UNROLL
  for (int c = 0; c < kCellCorners; c++)
    bits = std::uint8_t(bits | (cut[corner_slot(block, s, at, c)] & edges_from(c)));
  return bits;
}
/// Modulus of a cell, 0 if it is cut; and the same to find loose edges. Cut cells with cut elements also
/// cover their edges.
struct CellModulus {
  Real young, covers;  // [Pa]
};
/// `cut_edges`: of the cell; `lowest`: Cuts::cut of its lowest node.
TURGOR_HD inline CellModulus cell_modulus(Real whole, int cut_edges, int lowest) {
  const bool is_cut_cell = (lowest & kCutCell) != 0;
  return {cut_edges != 0 || is_cut_cell ? 0 : whole, cut_edges != 0 && !is_cut_cell ? 0 : whole};
}
/// Stiffness of edge e of node s as a spring; 0 if it is cut, or if a cell covers it. `covered`: sum of
/// CellModulus::covers over its cells; `lower_bits`: Cuts::cut of its lower end [N/m].
[[gnu::always_inline]] TURGOR_HD inline Real loose_stiffness(const NodeArrays& n, const Neighbors& stencil,
                                                             int s, int e, std::uint8_t lower_bits,
                                                             Real covered) {
  const bool loose = (covered <= 0) & (is_cut(lower_bits, e / 2) == 0);
  return loose ? stencil.scale[e] * n.root[s] * n.root[s + stencil.offset[e]] : 0;
}

/// Springs and volumes around node a. Both use the same edge vectors. `spring(e)` and `tet(t)` are 1 for
/// uncut elements and 0 for cut ones; t is the argument of for_each_incident_tet.
template <bool kWithVolumes, class Spring, class Tet>
[[gnu::always_inline]] TURGOR_HD inline NodeSystem incident_springs(const NodeArrays& n,
                                                                    const Neighbors& stencil,
                                                                    Real rest_volume, Real volume_scale,
                                                                    int a, const Spring& spring,
                                                                    const Tet& tet) {
  NodeSystem s;
  // springs
  Vec3 d[kNeighborCount];
  Real root[kNeighborCount];
  TURGOR_UNROLL
  for (int e = 0; e < kNeighborCount; e++) {
    const int b = a + stencil.offset[e];
    d[e] = stencil.edge[e] + (n.u(b) - n.u(a));
    root[e] = n.root[b];
    add_spring(s, d[e], stencil.rest[e], stencil.scale[e] * n.root[a] * root[e] * spring(e));
  }
  // volumes
  if constexpr (kWithVolumes) {
    for_each_incident_tet([&](auto t) {
      const IncidentTet& at = incident_tet(t);
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

/// Solid cells around node a, which is corner n of cell n. `young(n)`: modulus of a whole cell, else 0 [Pa];
/// `center(n)`: its CellCenter, or NoCenters if all cells are full.
struct NoCenters {};
template <class Young, class Center = NoCenters>
[[gnu::always_inline]] TURGOR_HD inline NodeSystem incident_cells(
    const NodeArrays& n, const SolidLaw& law, const NodeBlock& block, int a, const Young& young,
    [[maybe_unused]] const Center& center = {}) {
  NodeSystem s;
  Vec3 u[kBlockNodes];
  TURGOR_UNROLL
  for (int b = 0; b < kBlockNodes; b++) u[b] = n.u(a + block.offset[b]) - n.u(a);
  TURGOR_UNROLL
  for (int at = 0; at < kCellCorners; at++) {
    Vec3 d[kCellCorners];
    TURGOR_UNROLL
    for (int c = 0; c < kCellCorners; c++) d[c] = u[block_index(cell_corner(c) - cell_corner(at))];
    if constexpr (std::is_same_v<Center, NoCenters>) {
      add_cell(s, cell_gradient(d, at, law.slope), at, law, young(at));
    } else {
      const Vec3 point = center(at).in_half_cells();
      add_cell(s, cell_gradient_at(d, at, law.slope, point), shape_gradient(at, law.slope, point), law,
               young(at));
    }
  }
  return s;
}

/// One edge of node a with stiffness k; 0 if it is not loose [N/m].
[[gnu::always_inline]] TURGOR_HD inline void add_loose_edge(NodeSystem& s, const NodeArrays& n, Vec3 edge,
                                                            Real rest, int offset, int a, Real k) {
  const Real present =
      k > 0 ? Real(1) : Real(0);  // empty slots have no displacement; d must not depend on them
  add_spring(s, edge + (n.u(a + offset) - n.u(a)) * present, rest, k);
}
/// Loose edges of node a. `stiffness(e)`: 0 for other edges [N/m].
template <class Stiffness>
[[gnu::always_inline]] TURGOR_HD inline void add_loose_edges(NodeSystem& s, const NodeArrays& n,
                                                             const Neighbors& stencil, int a,
                                                             const Stiffness& stiffness) {
  TURGOR_UNROLL
  for (int e = 0; e < kNeighborCount; e++)
    add_loose_edge(s, n, stencil.edge[e], stencil.rest[e], stencil.offset[e], a, stiffness(e));
}

}  // namespace turgor::lattice
