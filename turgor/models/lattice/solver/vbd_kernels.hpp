// A step of vertex block descent by colours, as loops over plain pointers: a thread a node, and a thread a
// copy beside a blade. Springs and volumes or solid cells, skin, parts, loads, contacts. The same source runs
// on a CPU (CpuRun, ShuffledRun) and on a GPU; on a CPU step() is faster and means the same. Nobody sleeps
// here. The smooth part of a step is coarse_loops.hpp.
#pragma once

#include "turgor/models/lattice/mechanics/cut_elements.hpp"
#include "turgor/models/lattice/mechanics/node_contact.hpp"
#include "turgor/models/lattice/mechanics/node_forces.hpp"
#include "turgor/models/lattice/model/colors.hpp"
#include "turgor/models/lattice/solver/inertia.hpp"
#include "turgor/models/lattice/solver/step_kernels.hpp"

namespace turgor::lattice {

/// Everything that does not change, by value.
struct VbdRules {
  Neighbors neighbors[2];  // by the parity of i
  NodeBlock block[2];
  std::uint8_t holders[kNeighborCount];   // bit n: the cell of which a node is corner n holds its edge e
  std::uint8_t edges_from[kCellCorners];  // edges_from_corner
  SolidLaw solid;
  Real rest_volume, volume_scale;
};

/// The copies beside blades, by colours: follows from the cuts.
struct VirtualNodeOrdering {
  std::vector<ElementNode> virtual_nodes;
  ColorBegin virtual_nodes_of;
};

/// Forces left over at some nodes and copies.
struct PartOfResidual {
  double largest2 = 0, sum2 = 0;  // [N²]
};

/// A body on one side of the bus, for descent. Pointers are to arrays by slot unless another count is given.
struct VbdView {
  VbdRules rules;
  MovingNodes body;  // its groups by colours
  ColorBegin moving_of;
  Inertia inertia;
  const Real* young;                                                    // Model::cell_young; null: springs
  const std::uint8_t* row_cut;                                          // by row
  const int *skin_nodes, *corner_begin, *skin_row_begin, *lanes_begin;  // of Skin; null without
  const Vec3* pull;
  const SkinCorners* corners;
  const std::uint8_t* skin_cut;  // by triangle
  CutElementView parts;
  VirtualNodeShift* virtual_nodes_before;            // as many as there are copies
  const ElementNode *element_nodes, *virtual_nodes;  // slots ascend; CopySchedule
  int part_node_count, virtual_node_count;           // the latter of parts.copies, whether they bear or not
  ColorBegin virtual_nodes_of;
  NodeContact* contacts;  // slots ascend
  int contact_count;
  PartOfResidual* residual;  // by thread of ResidualOfGroups, then of ResidualOfCopy; null: not asked for
};

VbdRules descent_rules(const Model& model);
VirtualNodeOrdering copy_schedule(const Model& model, const State& state);

/// The first of `count` ascending entries that is not below.
template <class Entry, class SlotOf>
TURGOR_HD inline int first_of_slot(const Entry* entries, int count, int slot, const SlotOf& slot_of) {
  int begin = 0;
  while (count > 0) {
    const int half = count / 2;
    const bool below = slot_of(entries[begin + half]) < slot;
    begin = below ? begin + half + 1 : begin;
    count = below ? count - half - 1 : half;
  }
  return begin;
}

/// What a body is made of, as a constant of its kernels: one that has all of them needs the registers of the
/// largest, and a GPU then has half as many threads under way.
enum class Elements { kSprings, kSpringsAndVolumes, kCells };
template <Elements kElements>
using ElementsConstant = std::integral_constant<Elements, kElements>;

inline Elements elements_of(const VbdView& v) {
  if (v.young != nullptr) return Elements::kCells;
  return v.rules.volume_scale > 0 ? Elements::kSpringsAndVolumes : Elements::kSprings;
}
/// Calls f with the body's ElementsConstant.
template <class F>
void with_elements(const VbdView& v, const F& f) {
  switch (elements_of(v)) {
    case Elements::kSprings:
      return f(ElementsConstant<Elements::kSprings>{});
    case Elements::kSpringsAndVolumes:
      return f(ElementsConstant<Elements::kSpringsAndVolumes>{});
    case Elements::kCells:
      return f(ElementsConstant<Elements::kCells>{});
  }
}

/// What springs or cells, skin and parts ask of a node.
template <Elements kElements>
struct NodeForces {
  const VbdView& v;

  TURGOR_HD NodeSystem operator()(int s) const {
    const int parity = s / v.body.half & 1;
    const bool cut = v.row_cut[s / (2 * v.body.half)];
    NodeSystem system;
    if constexpr (kElements == Elements::kCells)
      system = of_cells(s, parity, cut);
    else
      system = of_springs(s, parity, cut);
    if (v.skin_nodes != nullptr) add_skin(s, system);
    if (cut) add_parts(s, system);
    return system;
  }

  TURGOR_HD bool is_cut(int lower, int family) const { return v.body.nodes.cut[lower] >> family & 1; }
  TURGOR_HD bool is_edge_cut(int s, const Neighbors& around, int e) const {
    return is_cut(e % 2 == 0 ? s : s + around.offset[e], e / 2);
  }

  TURGOR_HD NodeSystem of_springs(int s, int parity, bool cut) const {
    const Neighbors& around = v.rules.neighbors[parity];
    const auto spring = [&](int e) { return cut && is_edge_cut(s, around, e) ? Real(0) : Real(1); };
    const auto tet = [&](auto t) {
      const TetAround& at = tet_around(t);
      bool any = false;
      if (cut)
        for (const EdgeAround edge : at.edge)
          any |= is_cut(edge.lower < 0 ? s : s + around.offset[edge.lower], edge.family);
      return any ? Real(0) : Real(1);
    };
    return springs_around<kElements == Elements::kSpringsAndVolumes>(
        v.body.nodes, around, v.rules.rest_volume, v.rules.volume_scale, s, spring, tet);
  }

  TURGOR_HD NodeSystem of_cells(int s, int parity, bool cut) const {
    const NodeBlock& block = v.rules.block[parity];
    const Neighbors& around = v.rules.neighbors[parity];
    Real young[kCellCorners], holds[kCellCorners];
    for (int at = 0; at < kCellCorners; at++) {
      const auto corner = [&](int c) {
        return s + block.offset[block_index(cell_corner(c) - cell_corner(at))];
      };
      young[at] = holds[at] = v.young[corner(0)];
      if (!cut) continue;
      int bits = 0;
      for (int c = 0; c < kCellCorners; c++) bits |= v.body.nodes.cut[corner(c)] & v.rules.edges_from[c];
      const bool parted = v.body.nodes.cut[corner(0)] & kIsCut;
      if (bits || parted) young[at] = 0;
      if (bits && !parted) holds[at] = 0;
    }
    NodeSystem system =
        cells_around(v.body.nodes, v.rules.solid, block, s, [&](int at) { return young[at]; });
    add_loose_edges(system, v.body.nodes, around, s, [&](int e) {
      Real held = 0;
      for (int at = 0; at < kCellCorners; at++)
        if (v.rules.holders[e] >> at & 1) held += holds[at];
      const bool loose = held <= 0 && !is_edge_cut(s, around, e);
      return loose ? around.scale[e] * v.body.nodes.root[s] * v.body.nodes.root[s + around.offset[e]]
                   : Real(0);
    });
    return system;
  }

  TURGOR_HD void add_skin(int s, NodeSystem& system) const {
    const int row = s / v.body.half, first_node = v.skin_row_begin[row],
              count = v.skin_row_begin[row + 1] - first_node;
    const int at =
        first_node + first_of_slot(v.skin_nodes + first_node, count, s, [](int slot) { return slot; });
    if (at == first_node + count || v.skin_nodes[at] != s) return;
    const int first = v.corner_begin[first_node];
    system.f -= v.pull[at];
    for (int c = v.corner_begin[at]; c < v.corner_begin[at + 1]; c++) {
      const SkinCorners& lanes = v.corners[v.lanes_begin[row] + (c - first) / kSkinLanes];
      const int lane = (c - first) % kSkinLanes;
      if (!v.skin_cut[lanes.triangle[lane]]) add(system, v.parts.skin.gather(lanes, lane, v.body.nodes));
    }
  }

  TURGOR_HD void add_parts(int s, NodeSystem& system) const {
    const auto slot_of = [](const ElementNode& node) { return node.slot; };
    for (int n = first_of_slot(v.element_nodes, v.part_node_count, s, slot_of);
         n < v.part_node_count && v.element_nodes[n].slot == s; n++)
      add(system, v.parts.gather(v.element_nodes[n]));
  }
};

TURGOR_HD inline std::span<NodeContact> contacts_at(const VbdView& v, int s) {
  const auto slot_of = [](const NodeContact& c) { return c.slot; };
  const int first = first_of_slot(v.contacts, v.contact_count, s, slot_of);
  int end = first;
  while (end < v.contact_count && v.contacts[end].slot == s) end++;
  return {v.contacts + first, std::size_t(end - first)};
}

/// Moves a node.
template <Elements kElements>
struct SolveNode {
  VbdView v;
  int begin;  // of the colour's groups

  TURGOR_HD void operator()(std::size_t n) const {
    const int s = v.body.slot(std::size_t(begin) * kGroup + n);
    if (!(v.body.nodes.w[s] > 0)) return;
    NodeSystem system = NodeForces<kElements>{v}(s);
    const Vec3 to_inertial = v.inertia(s) - v.body.nodes.u(s);
    const Real mobility = v.inertia.dt * v.inertia.dt * v.body.nodes.w[s];
    const std::span<NodeContact> touched = contacts_at(v, s);
    if (!touched.empty()) press_node(touched, v.body.nodes, to_inertial, mobility, system);
    const Vec3 way = newton_step(system, to_inertial, mobility);
    v.body.nodes.ux[s] += way.x, v.body.nodes.uy[s] += way.y, v.body.nodes.uz[s] += way.z;
    for (NodeContact& c : touched) c.force = contact_force(c, contact_displacement(c, v.body.nodes)).force;
  }
};

/// Moves a copy.
struct SolveVirtualNode {
  VbdView v;
  int begin;

  TURGOR_HD void operator()(std::size_t n) const { v.parts.solve(v.virtual_nodes[std::size_t(begin) + n]); }
};

/// Where a copy was when the step began.
struct KeepCopy {
  VbdView v;
  TURGOR_HD void operator()(std::size_t n) const { v.virtual_nodes_before[n] = v.parts.virtual_nodes[n]; }
};
struct GoBackCopy {
  VbdView v;
  TURGOR_HD void operator()(std::size_t n) const { v.parts.virtual_nodes[n] = v.virtual_nodes_before[n]; }
};

/// A thread adds up what is left over in so many groups.
constexpr int kGroupsTogether = 8;
TURGOR_HD inline int residuals_of_groups(const VbdView& v) {
  return (v.body.moving_count + kGroupsTogether - 1) / kGroupsTogether;
}
TURGOR_HD inline void add_residual(Vec3d force, PartOfResidual& sum) {
  const double squared = dot(force, force);
  sum.largest2 = squared > sum.largest2 ? squared : sum.largest2;
  sum.sum2 += squared;
}
/// Forces left over at the nodes of some groups; the sums are added up on the host, in order.
template <Elements kElements>
struct ResidualOfGroups {
  VbdView v;

  TURGOR_HD void operator()(std::size_t n) const {
    constexpr std::size_t kNodes = std::size_t(kGroupsTogether) * kGroup;
    const std::size_t begin = n * kNodes, all = v.body.count();
    PartOfResidual sum;
    for (std::size_t at = begin; at < all && at < begin + kNodes; at++)
      if (const int s = v.body.slot(at); v.body.moves(s)) add_residual(residual_forces(s), sum);
    v.residual[n] = sum;
  }
  TURGOR_HD Vec3d residual_forces(int s) const {
    NodeSystem system = NodeForces<kElements>{v}(s);
    for (const NodeContact& c : contacts_at(v, s)) system.f += c.force;
    const double dt = double(v.inertia.dt);
    return Vec3d(system.f) + Vec3d(v.inertia(s) - v.body.nodes.u(s)) / (double(v.body.nodes.w[s]) * dt * dt);
  }
};
struct ResidualOfCopy {
  VbdView v;
  TURGOR_HD void operator()(std::size_t n) const {
    const ElementNode& copy = v.virtual_nodes[n];
    PartOfResidual sum;
    if (v.body.nodes.w[copy.slot] > 0) add_residual(Vec3d(v.parts.gather(copy).f), sum);
    v.residual[std::size_t(residuals_of_groups(v)) + n] = sum;
  }
};

template <class Run>
void sweep_descent_with(const Run& run, const VbdView& v, Order order) {
  for (int turn = 0; turn < kColorCount; turn++) {
    const int c = order == Order::kBackward ? kColorCount - 1 - turn : turn;
    const int *nodes = v.moving_of.begin + c, *virtual_nodes = v.virtual_nodes_of.begin + c;
    with_elements(v, [&](auto of) {
      run(std::size_t(nodes[1] - nodes[0]) * kGroup, SolveNode<of()>{v, nodes[0]});
    });
    run(std::size_t(virtual_nodes[1] - virtual_nodes[0]), SolveVirtualNode{v, virtual_nodes[0]});
  }
}
template <class Run>
void measure_residual_with(const Run& run, const VbdView& v) {
  with_elements(v, [&](auto of) { run(std::size_t(residuals_of_groups(v)), ResidualOfGroups<of()>{v}); });
  run(std::size_t(v.virtual_nodes_of.begin[kColorCount]), ResidualOfCopy{v});
}

/// How a step of descent begins, follows from the body and its speed.
struct VbdStart {
  bool held = true;  // something of the body: then weight waits for the sweeps
  Real wild = 0;     // difference of neighbours' velocities from which on they begin at rest; 0: none is so
};

/// What a step does to the view's arrays before its sweeps; the marks must be fresh. `loads` are on the same
/// side, their slots ascend.
template <class Run>
void predict_descent_with(const Run& run, const VbdView& v, std::span<const NodeLoad> loads, VbdStart start) {
  const Real dt = v.inertia.dt;
  run(std::size_t(v.virtual_node_count), KeepCopy{v});
  if (start.wild > 0)
    run(v.body.count(), FindWild{v.body, {v.rules.neighbors[0], v.rules.neighbors[1]}, start.wild});
  run(v.body.count(), PredictNode{v.body, start.held ? Vec3{} : v.inertia.fall, dt});
  run(loads.size(), AddLoad{v.body, loads.data(), int(loads.size()), dt});
}
/// And its sweeps, and what is left behind. `correct` is called where the smooth part of a step is solved
/// for.
template <class Run, class Correct>
void sweep_and_finish_descent_with(const Run& run, const VbdView& v, const SolverParams& solver, double dt,
                                   const Correct& correct) {
  for (int sweep = 0; sweep < solver.sweeps; sweep++) {
    if (is_turn(v.young != nullptr, sweep, solver.sweeps)) correct();
    sweep_descent_with(run, v, sweep_order(v.young != nullptr, sweep, solver.sweeps));
  }
  correct();
  if (v.residual != nullptr) measure_residual_with(run, v);
  run(v.body.count(), FinishNode{v.body, speed_scale(solver, dt)});
}

}  // namespace turgor::lattice
