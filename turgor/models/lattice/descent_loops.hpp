// A sweep of vertex block descent by colours, as loops over plain pointers: a thread a node, and a thread a
// copy beside a blade. Springs and volumes or solid cells, skin, parts, contacts. The same source runs on a
// CPU (CpuRun, ShuffledRun) and is compiled for a GPU; on a CPU sweep_descent is faster and means the same.
// Nobody sleeps here.
#pragma once

#include "turgor/models/lattice/colours.hpp"
#include "turgor/models/lattice/moving.hpp"
#include "turgor/models/lattice/node_contact.hpp"
#include "turgor/models/lattice/node_forces.hpp"
#include "turgor/models/lattice/parts.hpp"

namespace turgor::lattice {

/// Everything that does not change, by value.
struct DescentRules {
  int half;                  // Lattice::half
  Neighbours neighbours[2];  // by the parity of i
  NodeBlock block[2];
  TetAround tets[24];                     // kTetsAround
  std::uint8_t holders[kNeighbourCount];  // bit n: the cell of which a node is corner n holds its edge e
  std::uint8_t edges_from[kCellCorners];  // edges_from_corner
  SolidLaw solid;
  Real rest_volume, volume_scale;
};

/// What is done when, by colours.
struct DescentSchedule {
  std::vector<int> moving;  // first slots of groups in which something can move
  ColourBegin moving_of;
};
/// Follows from the cuts.
struct CopySchedule {
  std::vector<PartNode> copies;
  ColourBegin copies_of;
};

/// A body on one side of the bus, for the sweeps of one step. Pointers are to arrays by slot unless another
/// count is given.
struct DescentView {
  DescentRules rules;
  NodeArrays nodes;
  Inertia inertia;
  const Real* young;            // Model::cell_young; null: springs
  const std::uint8_t* row_cut;  // by row
  const int* moving;            // DescentSchedule
  ColourBegin moving_of;
  const int *skin_nodes, *corner_begin, *skin_row_begin, *lanes_begin;  // of Skin; null without
  const Vec3* pull;
  const SkinCorners* corners;
  const std::uint8_t* skin_cut;  // by triangle
  PartElements parts;
  const PartNode *part_nodes, *copies;  // slots ascend; CopySchedule
  int part_node_count;
  ColourBegin copies_of;
  NodeContact* contacts;  // slots ascend
  int contact_count;
};

DescentSchedule descent_schedule(const Model& model);
CopySchedule copy_schedule(const Model& model, const State& state);
/// On a CPU: of the body itself.
DescentView descent_view(const Model& model, const DescentSchedule& schedule, const CopySchedule& copies,
                         State& state, const Inputs& inputs, double dt);

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

/// Moves a node.
struct DescendNode {
  DescentView v;
  int begin;

  TURGOR_HD void operator()(std::size_t n) const {
    const int s = v.moving[std::size_t(begin) + n / kGroup] + int(n % kGroup);
    if (!(v.nodes.w[s] > 0)) return;
    const int parity = s / v.rules.half & 1;
    const bool cut = v.row_cut[s / (2 * v.rules.half)];
    NodeSystem system = v.young != nullptr ? of_cells(s, parity, cut) : of_springs(s, parity, cut);
    if (v.skin_nodes != nullptr) add_skin(s, system);
    if (cut) add_parts(s, system);
    const Vec3 to_inertial = v.inertia(s) - v.nodes.u(s);
    const Real mobility = v.inertia.dt * v.inertia.dt * v.nodes.w[s];
    const std::span<NodeContact> touched = contacts(s);
    if (!touched.empty()) press_node(touched, v.nodes, to_inertial, mobility, system);
    const Vec3 way = newton_step(system, to_inertial, mobility);
    v.nodes.ux[s] += way.x, v.nodes.uy[s] += way.y, v.nodes.uz[s] += way.z;
    for (NodeContact& c : touched) c.force = contact_force(c, contact_displacement(c, v.nodes)).force;
  }

  TURGOR_HD bool is_cut(int lower, int family) const { return v.nodes.cut[lower] >> family & 1; }
  TURGOR_HD bool is_edge_cut(int s, const Neighbours& around, int e) const {
    return is_cut(e % 2 == 0 ? s : s + around.offset[e], e / 2);
  }

  TURGOR_HD NodeSystem of_springs(int s, int parity, bool cut) const {
    const Neighbours& around = v.rules.neighbours[parity];
    const auto spring = [&](int e) { return cut && is_edge_cut(s, around, e) ? Real(0) : Real(1); };
    const auto tet = [&](int t) {
      bool any = false;
      if (cut)
        for (const EdgeAround edge : v.rules.tets[t].edge)
          any |= is_cut(edge.lower < 0 ? s : s + around.offset[edge.lower], edge.family);
      return any ? Real(0) : Real(1);
    };
    if (v.rules.volume_scale > 0)
      return springs_around<true>(v.nodes, around, v.rules.tets, v.rules.rest_volume, v.rules.volume_scale, s,
                                  spring, tet);
    return springs_around<false>(v.nodes, around, v.rules.tets, v.rules.rest_volume, v.rules.volume_scale, s,
                                 spring, tet);
  }

  TURGOR_HD NodeSystem of_cells(int s, int parity, bool cut) const {
    const NodeBlock& block = v.rules.block[parity];
    const Neighbours& around = v.rules.neighbours[parity];
    Real young[kCellCorners], holds[kCellCorners];
    for (int at = 0; at < kCellCorners; at++) {
      const auto corner = [&](int c) {
        return s + block.offset[block_index(cell_corner(c) - cell_corner(at))];
      };
      young[at] = holds[at] = v.young[corner(0)];
      if (!cut) continue;
      int bits = 0;
      for (int c = 0; c < kCellCorners; c++) bits |= v.nodes.cut[corner(c)] & v.rules.edges_from[c];
      const bool parted = v.nodes.cut[corner(0)] & kParted;
      if (bits || parted) young[at] = 0;
      if (bits && !parted) holds[at] = 0;
    }
    NodeSystem system = cells_around(v.nodes, v.rules.solid, block, s, [&](int at) { return young[at]; });
    add_loose_edges(system, v.nodes, around, s, [&](int e) {
      Real held = 0;
      for (int at = 0; at < kCellCorners; at++)
        if (v.rules.holders[e] >> at & 1) held += holds[at];
      const bool loose = held <= 0 && !is_edge_cut(s, around, e);
      return loose ? around.scale[e] * v.nodes.root[s] * v.nodes.root[s + around.offset[e]] : Real(0);
    });
    return system;
  }

  TURGOR_HD void add_skin(int s, NodeSystem& system) const {
    const int row = s / v.rules.half, first_node = v.skin_row_begin[row],
              count = v.skin_row_begin[row + 1] - first_node;
    const int at =
        first_node + first_of_slot(v.skin_nodes + first_node, count, s, [](int slot) { return slot; });
    if (at == first_node + count || v.skin_nodes[at] != s) return;
    const int first = v.corner_begin[first_node];
    system.f -= v.pull[at];
    for (int c = v.corner_begin[at]; c < v.corner_begin[at + 1]; c++) {
      const SkinCorners& lanes = v.corners[v.lanes_begin[row] + (c - first) / kSkinLanes];
      const int lane = (c - first) % kSkinLanes;
      if (!v.skin_cut[lanes.triangle[lane]]) add(system, v.parts.skin.gather(lanes, lane, v.nodes));
    }
  }

  TURGOR_HD void add_parts(int s, NodeSystem& system) const {
    const auto slot_of = [](const PartNode& node) { return node.slot; };
    for (int n = first_of_slot(v.part_nodes, v.part_node_count, s, slot_of);
         n < v.part_node_count && v.part_nodes[n].slot == s; n++)
      add(system, v.parts.gather(v.part_nodes[n]));
  }

  TURGOR_HD std::span<NodeContact> contacts(int s) const {
    const auto slot_of = [](const NodeContact& c) { return c.slot; };
    const int first = first_of_slot(v.contacts, v.contact_count, s, slot_of);
    int end = first;
    while (end < v.contact_count && v.contacts[end].slot == s) end++;
    return {v.contacts + first, std::size_t(end - first)};
  }
};

/// Moves a copy.
struct DescendCopy {
  DescentView v;
  int begin;

  TURGOR_HD void operator()(std::size_t n) const { v.parts.solve(v.copies[std::size_t(begin) + n]); }
};

template <class Run>
void sweep_descent_with(const Run& run, const DescentView& v, Order order) {
  for (int turn = 0; turn < kColourCount; turn++) {
    const int c = order == Order::kBackward ? kColourCount - 1 - turn : turn;
    const int *nodes = v.moving_of.begin + c, *copies = v.copies_of.begin + c;
    run(std::size_t(nodes[1] - nodes[0]) * kGroup, DescendNode{v, nodes[0]});
    run(std::size_t(copies[1] - copies[0]), DescendCopy{v, copies[0]});
  }
}

}  // namespace turgor::lattice
