// Kernels of a colored VBD step on plain pointers: one thread per node or virtual node. They cover springs
// and volumes or solid cells, skin, cut elements, loads and contacts. The same source runs on the CPU
// (CpuRun, ShuffledRun) and on a GPU. On a CPU, step() is faster and gives the same result. Rows never sleep
// in these kernels. The coarse correction is in coarse_kernels.hpp.
#pragma once

#include "turgor/models/lattice/mechanics/cut_elements.hpp"
#include "turgor/models/lattice/mechanics/node_contact.hpp"
#include "turgor/models/lattice/mechanics/node_forces.hpp"
#include "turgor/models/lattice/model/colors.hpp"
#include "turgor/models/lattice/solver/inertia.hpp"
#include "turgor/models/lattice/solver/residual_sum.hpp"
#include "turgor/models/lattice/solver/step_kernels.hpp"

namespace turgor::lattice {

/// Constants of the kernels, passed by value.
struct VbdRules {
  Neighbors neighbors[2];  // by parity of i
  NodeBlock block[2];
  std::uint8_t covering_cells[kNeighborCount];  // bit n: the cell whose corner n is the node contains edge e
  SolidLaw solid;
  Real rest_volume, volume_scale;
};

/// Virtual nodes by color, derived from the cuts.
struct VirtualNodeOrdering {
  std::vector<ElementNode> virtual_nodes;
  ColorBegin virtual_nodes_of_color;
};

/// Body on host or device, for VBD. Pointers are to arrays by slot unless another count is given.
struct VbdView {
  VbdRules rules;
  FreeNodes body;  // groups by color
  ColorBegin free_groups_of_color;
  Inertia inertia;
  const Real* young;              // Anatomy::cell_young; null with springs
  const std::uint32_t* center;    // Anatomy::cell_center; null without partial cells
  const std::uint8_t* row_cut;    // by row
  const std::uint8_t* is_listed;  // ListedNodes
  const int* listed;
  ColorBegin listed_of_color;
  SkinView skin;
  CutElementView cut_elements;
  VirtualNodeDisplacement* virtual_nodes_before;     // as many as virtual nodes
  const ElementNode *element_nodes, *virtual_nodes;  // slots ascend; VirtualNodeOrdering
  int element_node_count,
      virtual_node_count;  // the latter counts all virtual nodes, with or without elements
  ColorBegin virtual_nodes_of_color;
  NodeContact* contacts;  // slots ascend
  int contact_count;
  ResidualSum* residual;  // by thread of GroupResidual, then of VirtualNodeResidual; null: not measured
};

VbdRules vbd_rules(const Model& model);
/// Nodes with other elements than springs or whole cells: skin, loose edges or cut elements; and nodes with
/// contacts. Kernels of their own process them, so that the others need fewer registers.
struct ListedNodes {
  std::vector<std::uint8_t> is_listed;  // by slot
  std::vector<int> slots;               // by color
  ColorBegin of_color;
};
ListedNodes list_nodes(const Model& model, std::span<const std::uint8_t> row_cut,
                       std::span<const int> in_contact);
VirtualNodeOrdering virtual_node_ordering(const Model& model, const CutElements& elements);

/// Binary search: index of the first entry whose slot is not below `slot`.
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

/// Elements of a body, as a template argument of its kernels. A kernel with all kinds of elements needs the
/// registers of the largest one, and a GPU then runs half as many threads.
enum class Elements { kSprings, kSpringsAndVolumes, kCells, kPartialCells };
template <Elements kElements>
using ElementsConstant = std::integral_constant<Elements, kElements>;

inline Elements elements_of(const VbdView& v) {
  if (v.young != nullptr) return v.center != nullptr ? Elements::kPartialCells : Elements::kCells;
  return v.rules.volume_scale > 0 ? Elements::kSpringsAndVolumes : Elements::kSprings;
}
/// Calls f with the ElementsConstant of the body.
template <class F>
void with_elements(const VbdView& v, const F& f) {
  switch (elements_of(v)) {
    case Elements::kSprings:
      return f(ElementsConstant<Elements::kSprings>{});
    case Elements::kSpringsAndVolumes:
      return f(ElementsConstant<Elements::kSpringsAndVolumes>{});
    case Elements::kCells:
      return f(ElementsConstant<Elements::kCells>{});
    case Elements::kPartialCells:
      return f(ElementsConstant<Elements::kPartialCells>{});
  }
}

/// Force and Hessian at a node that is not listed: uncut springs, or whole cells.
template <Elements kElements>
TURGOR_HD inline NodeSystem plain_system(const VbdView& v, const NodeBlock& block, const Neighbors& stencil,
                                         int s) {
  if constexpr (kElements == Elements::kCells || kElements == Elements::kPartialCells) {
    const auto young_of = [&](int at) { return v.young[corner_slot(block, s, at, 0)]; };
    if constexpr (kElements == Elements::kCells)
      return incident_cells(v.body.nodes, v.rules.solid, block, s, young_of);
    else
      return incident_cells(v.body.nodes, v.rules.solid, block, s, young_of,
                            [&](int at) { return CellCenter{v.center[corner_slot(block, s, at, 0)]}; });
  } else {
    return incident_springs<kElements == Elements::kSpringsAndVolumes>(
        v.body.nodes, stencil, v.rules.rest_volume, v.rules.volume_scale, s, [](int) { return Real(1); },
        [](auto) { return Real(1); });
  }
}

/// Force and Hessian at any node: springs or cells, skin and cut elements.
template <Elements kElements>
struct NodeForces {
  const VbdView& v;

  TURGOR_HD NodeSystem operator()(int s) const {
    // springs or cells
    const int parity = s / v.body.half & 1;
    const bool cut = v.row_cut[s / (2 * v.body.half)];
    NodeSystem system;
    if constexpr (kElements == Elements::kCells || kElements == Elements::kPartialCells)
      system = cell_system(s, parity, cut);
    else
      system = spring_system(s, parity, cut);
    // skin and cut elements
    if (v.skin.nodes != nullptr) add_skin(s, system);
    if (cut) add_cut_elements(s, system);
    return system;
  }

  TURGOR_HD NodeSystem spring_system(int s, int parity, bool cut) const {
    const Neighbors& stencil = v.rules.neighbors[parity];
    const std::uint8_t* bits = v.body.nodes.cut;
    const auto spring = [&](int e) {
      return cut && is_cut(bits[s + lower_end(stencil, e)], e / 2) ? Real(0) : Real(1);
    };
    const auto tet = [&](auto t) {
      int any = 0;
      if (cut)
        for (const IncidentEdge edge : incident_tet(t).edge)
          any |= is_cut(bits[s + lower_end(stencil, edge)], edge.family);
      return any ? Real(0) : Real(1);
    };
    return incident_springs<kElements == Elements::kSpringsAndVolumes>(
        v.body.nodes, stencil, v.rules.rest_volume, v.rules.volume_scale, s, spring, tet);
  }

  TURGOR_HD NodeSystem cell_system(int s, int parity, bool cut) const {
    const NodeBlock& block = v.rules.block[parity];
    const Neighbors& stencil = v.rules.neighbors[parity];
    // moduli of the incident cells, 0 in cut cells
    Real young[kCellCorners], covers[kCellCorners];
    const std::uint8_t* bits = v.body.nodes.cut;
    for (int at = 0; at < kCellCorners; at++) {
      const int lowest = corner_slot(block, s, at, 0);
      young[at] = covers[at] = v.young[lowest];
      if (!cut) continue;
      const CellModulus cell = cell_modulus(young[at], cut_edges_of_cell(bits, block, s, at), bits[lowest]);
      young[at] = cell.young, covers[at] = cell.covers;
    }
    // forces of cells and loose edges
    const auto young_of = [&](int at) { return young[at]; };
    NodeSystem system;
    if constexpr (kElements == Elements::kCells)
      system = incident_cells(v.body.nodes, v.rules.solid, block, s, young_of);
    else
      system = incident_cells(v.body.nodes, v.rules.solid, block, s, young_of,
                              [&](int at) { return CellCenter{v.center[corner_slot(block, s, at, 0)]}; });
    add_loose_edges(system, v.body.nodes, stencil, s, [&](int e) {
      Real covered_by = 0;
      for (int at = 0; at < kCellCorners; at++)
        if (v.rules.covering_cells[e] >> at & 1) covered_by += covers[at];
      return loose_stiffness(v.body.nodes, stencil, s, e, bits[s + lower_end(stencil, e)], covered_by);
    });
    return system;
  }

  TURGOR_HD void add_skin(int s, NodeSystem& system) const {
    const int row = s / v.body.half, first = v.skin.row_begin[row], count = v.skin.row_begin[row + 1] - first;
    const int at = first + first_of_slot(v.skin.nodes + first, count, s, [](int slot) { return slot; });
    if (at == first + count || v.skin.nodes[at] != s) return;
    add_skin_corners(v.skin, row, at, system, [&](int batch, int lane) {
      return v.skin.patches ? v.cut_elements.skin.gather(v.skin.patches[batch], lane, v.body.nodes)
                            : v.cut_elements.skin.gather(v.skin.corners[batch], lane, v.body.nodes);
    });
  }

  /// As VbdSweep::shorten_steps_of_skin on the host.
  TURGOR_HD void shorten_step_of_skin(int s, Vec3 to_inertial, Real mobility, NodeSystem& system) const {
    const auto shorten = [&](Real growth) {
      if (growth > kCheckedGrowth) shorten_step(system, skin_step_share(growth), mobility);
    };
    // whole triangles
    if (v.skin.nodes != nullptr) {
      const int row = s / v.body.half, first = v.skin.row_begin[row],
                count = v.skin.row_begin[row + 1] - first;
      const int at = first + first_of_slot(v.skin.nodes + first, count, s, [](int slot) { return slot; });
      if (at != first + count && v.skin.nodes[at] == s)
        shorten(largest_growth(v.skin, v.cut_elements.skin, v.body.nodes, row, at,
                               newton_step(system, to_inertial, mobility)));
    }
    // cut ones
    const auto slot_of = [](const ElementNode& node) { return node.slot; };
    for (int n = first_of_slot(v.element_nodes, v.element_node_count, s, slot_of);
         n < v.element_node_count && v.element_nodes[n].slot == s; n++)
      shorten(v.cut_elements.largest_growth(v.element_nodes[n], newton_step(system, to_inertial, mobility)));
  }

  TURGOR_HD void add_cut_elements(int s, NodeSystem& system) const {
    const auto slot_of = [](const ElementNode& node) { return node.slot; };
    for (int n = first_of_slot(v.element_nodes, v.element_node_count, s, slot_of);
         n < v.element_node_count && v.element_nodes[n].slot == s; n++)
      add(system, v.cut_elements.gather(v.element_nodes[n]));
  }
};

TURGOR_HD inline std::span<NodeContact> contacts_at(const VbdView& v, int s) {
  const auto slot_of = [](const NodeContact& c) { return c.slot; };
  const int first = first_of_slot(v.contacts, v.contact_count, s, slot_of);
  int end = first;
  while (end < v.contact_count && v.contacts[end].slot == s) end++;
  return {v.contacts + first, std::size_t(end - first)};
}

/// Moves a node that is not listed by one Newton step. Removed nodes stay.
template <Elements kElements>
struct SolveNode {
  VbdView v;
  NodeBlock block;  // of the color
  Neighbors stencil;
  int begin;  // first group of the color

  TURGOR_HD void operator()(std::size_t n) const {
    const int s = v.body.slot(std::size_t(begin) * kGroup + n);
    if (!v.body.moves(s) || v.is_listed[s]) return;
    const NodeSystem system = plain_system<kElements>(v, block, stencil, s);
    const Vec3 du = newton_step(system, v.inertia(s) - v.body.nodes.u(s),
                                v.inertia.dt * v.inertia.dt * v.body.nodes.w[s]);
    v.body.nodes.ux[s] += du.x, v.body.nodes.uy[s] += du.y, v.body.nodes.uz[s] += du.z;
  }
};

/// Moves a listed node by one Newton step. Fixed and removed nodes stay.
template <Elements kElements>
struct SolveListedNode {
  VbdView v;
  int begin;  // first node of the color

  TURGOR_HD void operator()(std::size_t n) const {
    const int s = v.listed[std::size_t(begin) + n];
    if (!v.body.moves(s)) return update_forces(contacts_at(v, s), v.body.nodes);
    // forces of elements
    NodeSystem system = NodeForces<kElements>{v}(s);
    const Vec3 to_inertial = v.inertia(s) - v.body.nodes.u(s);
    const Real mobility = v.inertia.dt * v.inertia.dt * v.body.nodes.w[s];
    // contacts
    const std::span<NodeContact> node_contacts = contacts_at(v, s);
    if (!node_contacts.empty()) add_contacts(node_contacts, v.body.nodes, to_inertial, mobility, system);
    // Newton step
    if (v.cut_elements.skin.law == SkinLaw::kExponential)
      NodeForces<kElements>{v}.shorten_step_of_skin(s, to_inertial, mobility, system);
    const Vec3 du = newton_step(system, to_inertial, mobility);
    v.body.nodes.ux[s] += du.x, v.body.nodes.uy[s] += du.y, v.body.nodes.uz[s] += du.z;
    // contact forces
    update_forces(node_contacts, v.body.nodes);
  }
};

/// Moves a virtual node to the minimum of the energy of its elements.
struct SolveVirtualNode {
  VbdView v;
  int begin;

  TURGOR_HD void operator()(std::size_t n) const {
    v.cut_elements.solve(v.virtual_nodes[std::size_t(begin) + n]);
  }
};

/// Saves the displacement of a virtual node before the step.
struct SaveVirtualNode {
  VbdView v;
  TURGOR_HD void operator()(std::size_t n) const {
    v.virtual_nodes_before[n] = v.cut_elements.virtual_nodes[n];
  }
};
struct RestoreVirtualNode {
  VbdView v;
  TURGOR_HD void operator()(std::size_t n) const {
    v.cut_elements.virtual_nodes[n] = v.virtual_nodes_before[n];
  }
};

/// Slot groups per thread in a residual sum.
constexpr int kGroupsPerSum = 8;
TURGOR_HD inline int residuals_of_groups(const VbdView& v) {
  return (v.body.free_group_count + kGroupsPerSum - 1) / kGroupsPerSum;
}
/// Residual of the nodes of some groups. The host adds the sums in order.
template <Elements kElements>
struct GroupResidual {
  VbdView v;

  TURGOR_HD void operator()(std::size_t n) const {
    constexpr std::size_t kNodes = std::size_t(kGroupsPerSum) * kGroup;
    const std::size_t begin = n * kNodes, all = v.body.count();
    ResidualSum sum;
    for (std::size_t at = begin; at < all && at < begin + kNodes; at++)
      if (const int s = v.body.slot(at); v.body.moves(s)) sum.add(residual_at(s));
    v.residual[n] = sum;
  }
  TURGOR_HD Vec3d residual_at(int s) const {
    NodeSystem system = NodeForces<kElements>{v}(s);
    for (const NodeContact& c : contacts_at(v, s)) system.f += c.force;
    return residual_force(system.f, v.inertia(s) - v.body.nodes.u(s), v.body.nodes.w[s],
                          double(v.inertia.dt));
  }
};
struct VirtualNodeResidual {
  VbdView v;
  TURGOR_HD void operator()(std::size_t n) const {
    const ElementNode& virtual_node = v.virtual_nodes[n];
    ResidualSum sum;
    if (v.body.nodes.w[virtual_node.slot] > 0) sum.add(Vec3d(v.cut_elements.gather(virtual_node).f));
    v.residual[std::size_t(residuals_of_groups(v)) + n] = sum;
  }
};

template <class Run>
void sweep_vbd_with(const Run& run, const VbdView& v, Order order) {
  for (int pass = 0; pass < kColorCount; pass++) {
    const int c = order == Order::kBackward ? kColorCount - 1 - pass : pass;
    const int *nodes = v.free_groups_of_color.begin + c, *listed = v.listed_of_color.begin + c,
              *virtual_nodes = v.virtual_nodes_of_color.begin + c;
    with_elements(v, [&](auto of) {
      run(std::size_t(nodes[1] - nodes[0]) * kGroup,
          SolveNode<of()>{v, v.rules.block[c & 1], v.rules.neighbors[c & 1], nodes[0]});
      run(std::size_t(listed[1] - listed[0]), SolveListedNode<of()>{v, listed[0]});
    });
    run(std::size_t(virtual_nodes[1] - virtual_nodes[0]), SolveVirtualNode{v, virtual_nodes[0]});
  }
}
template <class Run>
void measure_residual_with(const Run& run, const VbdView& v) {
  if (v.residual == nullptr) return;
  with_elements(v, [&](auto of) { run(std::size_t(residuals_of_groups(v)), GroupResidual<of()>{v}); });
  run(std::size_t(v.virtual_nodes_of_color.begin[kColorCount]), VirtualNodeResidual{v});
}

/// Phases of a VBD step (step_sequence.hpp) on the arrays of the view. `correct` applies the coarse
/// correction, if there is one.
template <class Run, class Correct>
struct VbdKernels : NodeKernels<Run> {
  const VbdView& view;
  ResidualSum* residual_before;  // as VbdView::residual
  bool held;                     // the body has fixed nodes: start without gravity
  Real
      diverging_speed;  // relative speed of neighbors above which the step starts from rest [m/s]; 0: no test
  Correct correct;

  void move_to_start() const {
    const FreeNodes& body = view.body;
    this->run(std::size_t(view.virtual_node_count), SaveVirtualNode{view});
    if (diverging_speed > 0)
      this->run(body.count(), FindDivergingNeighbors{
                                  body, {view.rules.neighbors[0], view.rules.neighbors[1]}, diverging_speed});
    this->run(body.count(), PredictNode{body, held ? Vec3{} : view.inertia.fall, view.inertia.dt});
  }
  void sweep(Order order) const { sweep_vbd_with(this->run, view, order); }
  bool alternates() const { return false; }  // contacts have no corrections
  void correct_between() const { correct(); }
  void correct_after() const { correct(); }
  void measure_residual_before() const {
    VbdView predicted = view;
    predicted.residual = residual_before;
    measure_residual_with(this->run, predicted);
  }
  void measure_residual_after() const { measure_residual_with(this->run, view); }
};

}  // namespace turgor::lattice
