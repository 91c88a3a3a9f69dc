#include "turgor/models/lattice/mechanics/cells.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/mechanics/law_cells.hpp"
#include "turgor/models/lattice/mechanics/node_forces.hpp"

namespace turgor::lattice {

namespace {

/// Young's modulus of a cell: the geometric mean over its corners, as for an edge over its ends. If some
/// corners are fixed, only free corners count, so that fixed bone begins at its nodes. Rim nodes do not
/// count, since their stiffness is that of the tissue around them. 0 if no corner is body, or if a corner is
/// not and there are no partial cells [Pa].
Real cell_young(const Model& model, Int3 corner, bool partial) {
  double all = 1, moving = 1;
  int body = 0, count = 0;
  for (int n = 0; n < kCellCorners; n++) {
    const auto slot = std::size_t(node_slot(model.anatomy.lattice, corner + cell_corner(n)));
    if (!is_body(model.anatomy.tissue[slot])) continue;
    const double root = model.springs.root_stiffness[slot];
    body++, all *= root;
    if (model.anatomy.inverse_mass[slot] > 0) moving *= root, count++;
  }
  if (body == 0 || (body < kCellCorners && !partial)) return 0;
  if (body == kCellCorners && (count == 0 || count == kCellCorners)) return Real(std::sqrt(std::sqrt(all)));
  return Real(count == 0 ? std::pow(all, 2.0 / body) : std::pow(moving, 2.0 / count));
}

bool is_whole(const Model& model, Int3 corner) {
  return contains(model.anatomy.lattice, corner) &&
         model.anatomy.cell_young[std::size_t(node_slot(model.anatomy.lattice, corner))] > 0;
}

/// True if an edge at this body node is in no whole cell.
bool has_edge_outside_cells(const Model& model, Int3 node) {
  bool whole[kCellCorners];
  for (int n = 0; n < kCellCorners; n++) whole[n] = is_whole(model, node - cell_corner(n));
  for (int e = 0; e < kNeighborCount; e++) {
    const Int3 offset = neighbor_offset(e), other = node + offset;
    if (!contains(model.anatomy.lattice, other)) continue;
    if (!is_body(model.anatomy.tissue[std::size_t(node_slot(model.anatomy.lattice, other))])) continue;
    bool covered = false;
    for (int n = 0; n < kCellCorners; n++) covered |= whole[n] && cell_contains(n, offset);
    if (!covered) return true;
  }
  return false;
}

/// True if a cell around this node has the center of its filled part elsewhere.
bool has_partial_cell(const Model& model, Int3 node) {
  if (model.anatomy.cell_center.empty()) return false;
  for (int n = 0; n < kCellCorners; n++)
    if (const Int3 cell = node - cell_corner(n);
        contains(model.anatomy.lattice, cell) &&
        model.anatomy.cell_center[std::size_t(node_slot(model.anatomy.lattice, cell))] != 0)
      return true;
  return false;
}

void mark_group(const Model& model, Int3 node, std::vector<IncidentElements>& incident_elements) {
  const int slot = node_slot(model.anatomy.lattice, node);
  if (!has_node(model, slot)) return;
  IncidentElements& group = incident_elements[std::size_t(slot / kGroup)];
  group = std::max(group, has_loose_edge(model, slot)     ? IncidentElements::kSprings
                          : has_partial_cell(model, node) ? IncidentElements::kPartialCells
                                                          : IncidentElements::kCells);
}

/// Moduli of the cells around sixteen nodes. A node is corner n of cell n.
struct IncidentCells {
  const Real* young[kCellCorners];            // of whole cells [Pa]
  const Real* covers[kCellCorners];           // positive: the edges of the cell are not loose
  const std::uint32_t* center[kCellCorners];  // CellCenter; null if all cells are full
};

void gather_cells(const NodeArrays& n, const SolidLaw& solid, const NodeBlock& block,
                  const IncidentCells& cells, int slot, int begin, SystemBuffer& __restrict out) {
  const SolidLaw law = solid;
  TURGOR_LANES
  for (int i = 0; i < kSpareSlots; i++)
    out.set(begin + i, incident_cells(n, law, block, slot + i, [&](int at) { return cells.young[at][i]; }));
}
/// The same with cells that are filled in part.
void gather_partial_cells(const NodeArrays& n, const SolidLaw& solid, const NodeBlock& block,
                          const IncidentCells& cells, int slot, int begin, SystemBuffer& __restrict out) {
  const SolidLaw law = solid;
  TURGOR_LANES
  for (int i = 0; i < kSpareSlots; i++)
    out.set(begin + i, incident_cells(
                           n, law, block, slot + i, [&](int at) { return cells.young[at][i]; },
                           [&](int at) { return CellCenter{cells.center[at][i]}; }));
}

/// Uncut cells around sixteen nodes, and cells that cover their edges. Cut cells with cut elements also cover
/// their edges.
struct WholeCells {
  Real young[kCellCorners][kSpareSlots];   // 0 in cut cells [Pa]
  Real covers[kCellCorners][kSpareSlots];  // 0 in cut cells without cut elements
};
void find_whole_cells(const NodeArrays& n, const NodeBlock& block, int slot, IncidentCells& cells,
                      WholeCells& out) {
  for (int at = 0; at < kCellCorners; at++) {
    std::uint8_t cut_edges[kSpareSlots];
    for (int i = 0; i < kSpareSlots; i++) cut_edges[i] = cut_edges_of_cell(n.cut, block, slot + i, at);
    const std::uint8_t* lowest = n.cut + corner_slot(block, slot, at, 0);
    for (int i = 0; i < kSpareSlots; i++) {
      const CellModulus cell = cell_modulus(cells.young[at][i], cut_edges[i], lowest[i]);
      out.young[at][i] = cell.young, out.covers[at][i] = cell.covers;
    }
    cells.young[at] = out.young[at], cells.covers[at] = out.covers[at];
  }
}

/// Spring stiffness of the loose edges around sixteen nodes; 0 for other edges [N/m].
struct UncoveredEdges {
  Real spring[kNeighborCount][kSpareSlots];
};
/// Finds edge kEdge of sixteen nodes. Returns true if it is loose at one of them. Loops have numbers of one
/// size each, because others vectorize only four wide.
template <int kEdge>
bool find_loose_edge(const NodeArrays& n, const Neighbors& stencil, const IncidentCells& cells, int slot,
                     bool with_cuts, Real (&spring)[kSpareSlots]) {
  // cells that contain the edge
  Real covered[kSpareSlots] = {};
  const auto add = [&](const Real* covers) {
    TURGOR_LANES
    for (int i = 0; i < kSpareSlots; i++) covered[i] += covers[i];
  };
  [&]<std::size_t... kAt>(std::index_sequence<kAt...>) {
    ((cell_contains(int(kAt), neighbor_offset(kEdge)) ? add(cells.covers[kAt]) : void()), ...);
  }
  (std::make_index_sequence<kCellCorners>{});
  if (with_cuts) {
    const std::uint8_t* cut = n.cut + slot + lower_end(stencil, kEdge);
    for (int i = 0; i < kSpareSlots; i++) covered[i] += Real(is_cut(cut[i], kEdge / 2));
  }
  // stiffness; bits of positive numbers, because a sum of them would have an order
  std::uint32_t any = 0;
  TURGOR_LANES
  for (int i = 0; i < kSpareSlots; i++) {
    spring[i] = loose_stiffness(n, stencil, slot + i, kEdge, 0, covered[i]);
    any |= std::bit_cast<std::uint32_t>(spring[i]);
  }
  return any != 0;
}
/// Returns a bit for every edge that is loose at one of the nodes.
int find_loose_edges(const NodeArrays& n, const Neighbors& stencil, const IncidentCells& cells, int slot,
                     bool with_cuts, UncoveredEdges& out) {
  return [&]<int... kEdge>(std::integer_sequence<int, kEdge...>) {
    return ((int(find_loose_edge<kEdge>(n, stencil, cells, slot, with_cuts, out.spring[kEdge])) << kEdge) |
            ...);
  }
  (std::make_integer_sequence<int, kNeighborCount>{});
}

/// Adds the edges of `found`, the result of find_loose_edges.
void add_springs(const NodeArrays& n, const Neighbors& stencil, const UncoveredEdges& loose, int found,
                 int slot, int begin, SystemBuffer& __restrict out) {
  for (int e = 0; e < kNeighborCount; e++) {
    if (!(found >> e & 1)) continue;
    const Vec3 edge = stencil.edge[e];
    const Real rest = stencil.rest[e];
    const int offset = stencil.offset[e];
    TURGOR_LANES
    for (int i = 0; i < kSpareSlots; i++) {
      NodeSystem s = out.get(begin + i);
      add_loose_edge(s, n, edge, rest, offset, slot + i, loose.spring[e][i]);
      out.set(begin + i, s);
    }
  }
}

/// Gathers all elements around the nodes of [slot, slot + kSpareSlots) into the buffer from `begin` on.
/// `found`: elements around these nodes in the uncut body.
void gather_sixteen(const SolidRow& row, int parity, int slot, int begin, bool with_cuts,
                    IncidentElements found, SystemBuffer& out) {
  const bool with_springs = with_cuts || found == IncidentElements::kSprings;
  const bool with_partial = row.center != nullptr && found >= IncidentElements::kPartialCells;
  const NodeBlock& block = row.block[parity];
  // moduli of the incident cells, 0 in cut cells
  IncidentCells cells;
  for (int at = 0; at < kCellCorners; at++) {
    const int lowest = slot + block.offset[block_index(-cell_corner(at))];
    cells.young[at] = cells.covers[at] = row.young + lowest;
    cells.center[at] = with_partial ? row.center + lowest : nullptr;
  }
  WholeCells whole;
  if (with_cuts) find_whole_cells(row.nodes, block, slot, cells, whole);
  // forces of cells
  if (row.laws)
    gather_law_cells(row.nodes, *row.laws, block, cells.young, slot, begin, out);
  else if (with_partial)
    gather_partial_cells(row.nodes, row.law, block, cells, slot, begin, out);
  else
    gather_cells(row.nodes, row.law, block, cells, slot, begin, out);
  if (!with_springs) return;
  // forces of loose edges
  UncoveredEdges loose;
  const int loose_edges = find_loose_edges(row.nodes, row.neighbors[parity], cells, slot, with_cuts, loose);
  add_springs(row.nodes, row.neighbors[parity], loose, loose_edges, slot, begin, out);
}

}  // namespace

bool has_loose_edge(const Model& model, int slot) {
  return is_body(model.anatomy.tissue[std::size_t(slot)]) &&
         has_edge_outside_cells(model, slot_node(model.anatomy.lattice, slot));
}

NodeBlock node_block(const Lattice& lattice, int parity) {
  NodeBlock block{};
  for (int z = -1; z <= 1; z++)
    for (int y = -1; y <= 1; y++)
      for (int x = -1; x <= 1; x++)
        block.offset[block_index({x, y, z})] = slot_offset(lattice, {x, y, z}, parity);
  return block;
}

void build_cells(const Exec& exec, const CellFill& fill, Model& model) {
  const Lattice& l = model.anatomy.lattice;
  const std::size_t slots = model.anatomy.inverse_mass.size();
  TURGOR_CHECK(slots % kGroup == 0, "half rows are whole numbers of groups");
  model.anatomy.cell_young.assign(slots, 0);
  model.vbd.incident_elements.assign(slots / kGroup, IncidentElements::kNothing);
  const auto for_each = [&](Int3 size, const auto& visit) {
    parallel_for(exec, std::size_t(size.z), [&](std::size_t k) {
      for (int j = 0; j < size.y; j++)
        for (int i = 0; i < size.x; i++) visit(Int3{i, j, int(k)});
    });
  };
  const bool partial = !fill.fraction.empty();
  if (partial) model.anatomy.cell_center.assign(slots, 0);
  TURGOR_CHECK(!partial || (fill.fraction.size() == sample_count(model.anatomy.grid) &&
                            fill.center.size() == fill.fraction.size()),
               "every cell has a filled fraction and a center");
  for_each(l.size - Int3{1, 1, 1}, [&](Int3 p) {
    const auto slot = std::size_t(node_slot(l, p));
    const Real young = cell_young(model, p, partial);
    model.anatomy.cell_young[slot] = young;
    if (!partial) return;
    const std::size_t n = sample_index(model.anatomy.grid, p.x, p.y, p.z);
    model.anatomy.cell_young[slot] = young * fill.fraction[n];
    if (young > 0 && fill.fraction[n] > 0) model.anatomy.cell_center[slot] = fill.center[n].bits;
  });
  for_each(l.size, [&](Int3 p) { mark_group(model, p, model.vbd.incident_elements); });
}

bool is_whole_cell(const Model& model, const Cuts& cuts, Int3 cell) {
  if (!is_whole(model, cell)) return false;
  const int slot = node_slot(model.anatomy.lattice, cell);
  if (!cuts.row_cut[std::size_t(slot / row_stride(model.anatomy.lattice))]) return true;
  int cut = cuts.cut[std::size_t(slot)] & kCutCell;
  for (int n = 0; n < kCellCorners; n++)
    cut |=
        cuts.cut[std::size_t(node_slot(model.anatomy.lattice, cell + cell_corner(n)))] & edges_from_corner(n);
  return cut == 0;
}

bool is_edge_covered(const Model& model, const Cuts& cuts, Int3 node, Int3 offset) {
  for (int n = 0; n < kCellCorners; n++) {
    const Int3 cell = node - cell_corner(n);
    if (!cell_contains(n, offset) || !contains(model.anatomy.lattice, cell)) continue;
    if (is_whole_cell(model, cuts, cell)) return true;
    if (cuts.cut[std::size_t(node_slot(model.anatomy.lattice, cell))] & kCutCell) return true;
  }
  return false;
}

SolidRow::SolidRow(const Model& m, State& s)
    : model(m),
      row_cut(s.cuts.row_cut.data()),
      nodes(node_arrays(m, s)),
      young(m.anatomy.cell_young.data()),
      center(m.anatomy.cell_center.empty() ? nullptr : m.anatomy.cell_center.data()),
      law(solid_law(m.anatomy.lattice.spacing, m.params.tissue.poisson)),
      block{node_block(m.anatomy.lattice, 0), node_block(m.anatomy.lattice, 1)},
      neighbors{neighbors_of(m, 0), neighbors_of(m, 1)} {
  if (const CellLawView view = cell_law_view(m, s); view.has_laws())
    laws = std::make_shared<CellLawView>(view);
}

void SolidRow::gather(int parity, int slot, int count, SystemBuffer& out) const {
  TURGOR_CHECK(slot % kGroup == 0 && count <= kLanes,
               "a chunk begins with a whole group and fits the buffer");
  // gather sixteen slots at a time
  const bool cut = row_cut[slot / row_stride(model.anatomy.lattice)];
  for (int begin = 0; begin < count; begin += kSpareSlots) {
    const auto group = std::size_t((slot + begin) / kGroup);
    const IncidentElements found =
        std::max(model.vbd.incident_elements[group], model.vbd.incident_elements[group + 1]);
    // empty space gets zero systems
    if (found == IncidentElements::kNothing)
      for (int i = begin; i < begin + kSpareSlots; i++) out.set(i, {});
    else
      gather_sixteen(*this, parity, slot + begin, begin, cut, found, out);
  }
}

}  // namespace turgor::lattice
