// Kernels of a colored PBD step on plain pointers: one thread per cell or node. The same source runs on the
// CPU (CpuRun, ShuffledRun) and on a GPU. On a CPU, step() is faster and gives the same result.
#pragma once

#include <utility>

#include "turgor/models/lattice/model/colors.hpp"
#include "turgor/models/lattice/solver/projections.hpp"
#include "turgor/models/lattice/solver/step_kernels.hpp"

namespace turgor::lattice {

/// Constants of the kernels, passed by value.
struct PbdRules {
  int corner_offset[2][kCellCorners];  // by the parity of i, from the cell's lowest node [slots]
  Vec3 edge[kFamilyCount];             // rest vectors [m]
  Real rest[kFamilyCount];             // [m]
  TetRest tet[6];
  Real rest_volume;                     // [m³]; 0: volumes are not projected
  Real skin_ratio, skin_amplification;  // rest area over area in the CT [1]; β [1]
};

/// Mass and stiffness of a node. The millions of nodes of a CT have a few thousand kinds. The eight passes of
/// a sweep read two bytes per node instead of eight.
struct alignas(8) NodeKind {
  Real w, root;  // inverse mass [1/kg]; root stiffness in [0, 1]

  friend bool operator==(NodeKind, NodeKind) = default;
};

struct PbdOrdering {
  std::vector<NodeKind> kinds;
  std::vector<std::uint16_t> kind;     // by slot: index into `kinds`
  std::vector<int> constraint_groups;  // first slots of groups with active constraints, by color
  std::vector<int> heads;              // first skin triangle of each cell, by color
  std::vector<int> next;               // by triangle: next one of its cell, or -1
  ColorBegin constraint_groups_of_color, heads_of_color;
};

/// Body on host or device, for PBD.
struct PbdView {
  PbdRules rules;
  FreeNodes body;
  const NodeKind* kinds;  // PbdOrdering
  const std::uint16_t* kind;
  const int* constraint_groups;
  ColorBegin constraint_groups_of_color;
  const SkinTriangle* triangles;
  const std::uint8_t* skin_cut;  // by triangle
  const int *next, *heads;
  ColorBegin heads_of_color;
};

PbdRules pbd_rules(const Model& model);
PbdOrdering pbd_ordering(const Model& model);

/// Corners of a cell (x + 2 y + 4 z) during the projection of its elements: loaded once and stored once.
/// Elements are template arguments, so that nvcc keeps all of it in registers.
struct CellCorners {
  const PbdRules& rules;
  const std::uint8_t* cut;  // by slot
  int at[kCellCorners];
  Vec3 u[kCellCorners];
  NodeKind kind[kCellCorners];

  TURGOR_HD CellCorners(const PbdView& v, int s) : rules(v.rules), cut(v.body.nodes.cut) {
    const int parity = s / v.body.half & 1;
    TURGOR_UNROLL
    for (int c = 0; c < kCellCorners; c++) {
      at[c] = s + rules.corner_offset[parity][c];
      u[c] = v.body.nodes.u(at[c]), kind[c] = v.kinds[v.kind[at[c]]];
    }
  }
  TURGOR_HD void store(const NodeArrays& n) const {
    TURGOR_UNROLL
    for (int c = 0; c < kCellCorners; c++) n.ux[at[c]] = u[c].x, n.uy[at[c]] = u[c].y, n.uz[at[c]] = u[c].z;
  }

  template <std::size_t kFamily>
  TURGOR_HD void project_edge() {
    constexpr int b = corner_of(kFamilies[kFamily]);
    lattice::project_edge(u[0], u[b], kind[0].w, kind[b].w, rules.edge[kFamily], rules.rest[kFamily],
                          edge_stiffness(kind[0].root, kind[b].root, cut[at[0]], kFamily));
  }
  template <std::size_t... kFamily>
  TURGOR_HD void project_edges(std::index_sequence<kFamily...>) {
    (project_edge<kFamily>(), ...);
  }

  template <std::size_t kTet>
  TURGOR_HD void project_tet() {
    constexpr std::array<Int3, 4> tet = kKuhnTets[kTet];
    constexpr std::array<TetEdge, 6> edges = tet_edges(tet);
    constexpr int a = corner_of(tet[0]), b = corner_of(tet[1]), c = corner_of(tet[2]), d = corner_of(tet[3]);
    const int corner[4] = {a, b, c, d};
    const Real whole = tet_stiffness(kind[a].root, kind[d].root, kind[b].root, kind[c].root, kind[d].root);
    const Real stiffness = any_cut(edges, [&](int n) { return cut[at[corner[n]]]; }) ? 0 : whole;
    lattice::project_tet(u[a], u[b], u[c], u[d], kind[a].w, kind[b].w, kind[c].w, kind[d].w, rules.tet[kTet],
                         rules.rest_volume, stiffness);
  }
  template <std::size_t... kTet>
  TURGOR_HD void project_tets(std::index_sequence<kTet...>) {
    (project_tet<kTet>(), ...);
  }
};

/// Projects the edges of a cell, then its tetrahedra.
template <bool kWithVolumes>
struct ProjectCell {
  PbdView v;
  int begin;

  TURGOR_HD void operator()(std::size_t n) const {
    const int s = v.constraint_groups[std::size_t(begin) + n / kGroup] + int(n % kGroup);
    if (!(v.kinds[v.kind[s]].root > 0)) return;  // no node, or an unused slot at the end of a row
    CellCorners cell(v, s);
    cell.project_edges(std::make_index_sequence<kFamilyCount>{});
    if constexpr (kWithVolumes) cell.project_tets(std::make_index_sequence<kKuhnTets.size()>{});
    cell.store(v.body.nodes);
  }
};

/// Projects the skin of a cell, one triangle after the other.
struct ProjectSkinCell {
  PbdView v;
  int begin;

  TURGOR_HD void operator()(std::size_t n) const {
    for (int t = v.heads[std::size_t(begin) + n]; t >= 0; t = v.next[t])
      if (!v.skin_cut[t]) project(v.triangles[t]);
  }
  TURGOR_HD void project(const SkinTriangle& t) const {
    const auto [a, b, c] = t.vertex;
    const NodeArrays& n = v.body.nodes;
    const SkinShift shift =
        project_skin_triangle({n.u(a), n.u(b), n.u(c)}, t.edge1, t.edge2, {n.w[a], n.w[b], n.w[c]},
                              v.rules.skin_ratio * t.area, t.stiffness, v.rules.skin_amplification);
    move(a, shift.a), move(b, shift.b), move(c, shift.c);
  }
  TURGOR_HD void move(int s, Vec3 by) const {
    v.body.nodes.ux[s] += by.x, v.body.nodes.uy[s] += by.y, v.body.nodes.uz[s] += by.z;
  }
};

/// One colored sweep.
template <class Run>
void sweep_pbd_with(const Run& run, const PbdView& v) {
  for (int c = 0; c < kColorCount; c++) {
    const int *cells = v.constraint_groups_of_color.begin + c, *skin = v.heads_of_color.begin + c;
    const std::size_t slots = std::size_t(cells[1] - cells[0]) * kGroup;
    if (v.rules.rest_volume > 0)
      run(slots, ProjectCell<true>{v, cells[0]});
    else
      run(slots, ProjectCell<false>{v, cells[0]});
    run(std::size_t(skin[1] - skin[0]), ProjectSkinCell{v, skin[0]});
  }
}

/// Phases of a PBD step (step_sequence.hpp) on the arrays of the view.
template <class Run>
struct PbdKernels : NodeKernels<Run> {
  const PbdView& view;
  Vec3 gravity;

  void move_to_start() const {
    const Real h = Real(this->dt);
    const Vec3 fall{h * h * gravity.x, h * h * gravity.y, h * h * gravity.z};
    this->run(view.body.count(), PredictNode{view.body, fall, h});
  }
  void sweep() const { sweep_pbd_with(this->run, view); }
};

}  // namespace turgor::lattice
