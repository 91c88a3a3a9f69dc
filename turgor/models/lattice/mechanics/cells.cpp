#include "turgor/models/lattice/mechanics/cells.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/models/lattice/mechanics/node_forces.hpp"

namespace turgor::lattice {

namespace {

/// Geometric mean of the corners' moduli, as an edge has that of its ends; of those that move, where a cell
/// has such: bone that is held begins at its nodes. 0 when a corner is no body [Pa].
Real cell_young(const Model& model, Int3 corner) {
  double all = 1, moving = 1;
  int count = 0;
  for (int n = 0; n < kCellCorners; n++) {
    const auto slot = std::size_t(node_slot(model.lattice, corner + cell_corner(n)));
    const double root = model.root_stiffness[slot];
    all *= root;
    if (model.inverse_mass[slot] > 0) moving *= root, count++;
  }
  if (all == 0 || count == 0 || count == kCellCorners) return Real(std::sqrt(std::sqrt(all)));
  return Real(std::pow(moving, 2.0 / count));
}

bool is_whole(const Model& model, Int3 corner) {
  return contains(model.lattice, corner) &&
         model.cell_young[std::size_t(node_slot(model.lattice, corner))] > 0;
}

/// Is there an edge at this node of the body that no whole cell holds?
bool has_loose_edge(const Model& model, Int3 node) {
  bool whole[kCellCorners];
  for (int n = 0; n < kCellCorners; n++) whole[n] = is_whole(model, node - cell_corner(n));
  for (int e = 0; e < kNeighborCount; e++) {
    const Int3 offset = neighbor_offset(e), other = node + offset;
    if (!contains(model.lattice, other)) continue;
    if (!is_body(model.tissue[std::size_t(node_slot(model.lattice, other))])) continue;
    bool held = false;
    for (int n = 0; n < kCellCorners; n++) held |= whole[n] && cell_holds(n, offset);
    if (!held) return true;
  }
  return false;
}

void mark_group(const Model& model, Int3 node, std::vector<Around>& around) {
  const int slot = node_slot(model.lattice, node);
  if (!is_body(model.tissue[std::size_t(slot)])) return;
  Around& group = around[std::size_t(slot / kGroup)];
  group = std::max(group, has_loose_edge(model, node) ? Around::kSprings : Around::kCells);
}

/// The cells around sixteen nodes: where each has its modulus. A node is corner n of cell n.
struct CellsAround {
  const Real* young[kCellCorners];  // of what is whole [Pa]
  const Real* holds[kCellCorners];  // more than 0: no edge in it is loose
};

void gather_cells(const NodeArrays& n, const SolidLaw& solid, const NodeBlock& block,
                  const CellsAround& cells, int slot, int begin, SystemBuffer& __restrict out) {
  const SolidLaw law = solid;
  TURGOR_LANES
  for (int i = 0; i < kSpareSlots; i++)
    out.set(begin + i, cells_around(n, law, block, slot + i, [&](int at) { return cells.young[at][i]; }));
}

/// Of the cells around sixteen nodes, those without a cut edge, and those that hold their edges: parts do,
/// too.
struct WholeCells {
  Real young[kCellCorners][kSpareSlots];  // 0 in cells with a cut edge [Pa]
  Real holds[kCellCorners][kSpareSlots];  // 0 in cells with a cut edge that are not in parts
};
void find_whole_cells(const NodeArrays& n, const NodeBlock& block, int slot, CellsAround& cells,
                      WholeCells& out) {
  for (int at = 0; at < kCellCorners; at++) {
    std::uint8_t bits[kSpareSlots] = {};
    const std::uint8_t* lowest = n.cut + slot + block.offset[block_index(cell_corner(0) - cell_corner(at))];
    for (int c = 0; c < kCellCorners; c++) {
      const std::uint8_t* cut = n.cut + slot + block.offset[block_index(cell_corner(c) - cell_corner(at))];
      for (int i = 0; i < kSpareSlots; i++) bits[i] |= cut[i] & edges_from_corner(c);
    }
    for (int i = 0; i < kSpareSlots; i++) {
      const bool parted = lowest[i] & kIsCut;
      out.young[at][i] = bits[i] || parted ? 0 : cells.young[at][i];
      out.holds[at][i] = bits[i] && !parted ? 0 : cells.young[at][i];
    }
    cells.young[at] = out.young[at], cells.holds[at] = out.holds[at];
  }
}

/// Stiffness of the edges around sixteen nodes that no whole cell holds, 0 for others [N/m].
struct LooseEdges {
  Real spring[kNeighborCount][kSpareSlots];
};
void find_loose_edges(const NodeArrays& n, const Neighbors& around, const CellsAround& cells, int slot,
                      LooseEdges& out) {
  const Real* root = n.root + slot;
  for (int e = 0; e < kNeighborCount; e++) {
    const int b = around.offset[e];
    const std::uint8_t* cut = n.cut + slot + (e % 2 == 0 ? 0 : b);
    Real held[kSpareSlots] = {};
    for (int at = 0; at < kCellCorners; at++)
      for (int i = 0; i < kSpareSlots && cell_holds(at, neighbor_offset(e)); i++)
        held[i] += cells.holds[at][i];
    for (int i = 0; i < kSpareSlots; i++) {
      const bool loose = (held[i] <= 0) & ((cut[i] >> e / 2 & 1) == 0);
      out.spring[e][i] = loose ? around.scale[e] * root[i] * root[b + i] : 0;
    }
  }
}

void add_springs(const NodeArrays& n, const Neighbors& around, const LooseEdges& loose, int slot, int begin,
                 SystemBuffer& __restrict out) {
  TURGOR_LANES
  for (int i = 0; i < kSpareSlots; i++) {
    NodeSystem s = out.get(begin + i);
    add_loose_edges(s, n, around, slot + i, [&](int e) { return loose.spring[e][i]; });
    out.set(begin + i, s);
  }
}

/// Everything around the nodes of [slot, slot + kSpareSlots), into the buffer from `begin` on.
void gather_sixteen(const SolidRow& row, int parity, int slot, int begin, bool with_cuts, bool with_springs,
                    SystemBuffer& out) {
  const NodeBlock& block = row.block[parity];
  CellsAround cells;
  for (int at = 0; at < kCellCorners; at++)
    cells.young[at] = cells.holds[at] = row.young + slot + block.offset[block_index(-cell_corner(at))];
  WholeCells whole;
  if (with_cuts) find_whole_cells(row.nodes, block, slot, cells, whole);
  gather_cells(row.nodes, row.law, block, cells, slot, begin, out);
  if (!with_springs) return;
  LooseEdges loose;
  find_loose_edges(row.nodes, row.neighbors[parity], cells, slot, loose);
  add_springs(row.nodes, row.neighbors[parity], loose, slot, begin, out);
}

}  // namespace

NodeBlock node_block(const Lattice& lattice, int parity) {
  NodeBlock block{};
  for (int z = -1; z <= 1; z++)
    for (int y = -1; y <= 1; y++)
      for (int x = -1; x <= 1; x++)
        block.offset[block_index({x, y, z})] = slot_offset(lattice, {x, y, z}, parity);
  return block;
}

void build_cells(const Exec& exec, Model& model) {
  const Lattice& l = model.lattice;
  const std::size_t slots = model.inverse_mass.size();
  model.cell_young.assign(slots, 0);
  model.around.assign(slots / kGroup, Around::kNothing);
  const auto for_each = [&](Int3 size, const auto& visit) {
    parallel_for(exec, std::size_t(size.z), [&](std::size_t k) {
      for (int j = 0; j < size.y; j++)
        for (int i = 0; i < size.x; i++) visit(Int3{i, j, int(k)});
    });
  };
  for_each(l.size - Int3{1, 1, 1},
           [&](Int3 p) { model.cell_young[std::size_t(node_slot(l, p))] = cell_young(model, p); });
  for_each(l.size, [&](Int3 p) { mark_group(model, p, model.around); });
}

bool is_whole_now(const Model& model, const State& state, Int3 cell) {
  if (!is_whole(model, cell)) return false;
  int cut = state.cut[std::size_t(node_slot(model.lattice, cell))] & kIsCut;
  for (int n = 0; n < kCellCorners; n++)
    cut |= state.cut[std::size_t(node_slot(model.lattice, cell + cell_corner(n)))] & edges_from_corner(n);
  return cut == 0;
}

bool is_held_now(const Model& model, const State& state, Int3 node, Int3 offset) {
  for (int n = 0; n < kCellCorners; n++) {
    const Int3 cell = node - cell_corner(n);
    if (!cell_holds(n, offset) || !contains(model.lattice, cell)) continue;
    const bool parted = (state.cut[std::size_t(node_slot(model.lattice, cell))] & kIsCut) != 0;
    if (parted || is_whole_now(model, state, cell)) return true;
  }
  return false;
}

SolidRow::SolidRow(const Model& m, State& s)
    : model(m),
      row_cut(s.row_cut.data()),
      nodes(node_arrays(m, s)),
      young(m.cell_young.data()),
      law(solid_law(m.lattice.step, m.params.tissue.poisson)),
      block{node_block(m.lattice, 0), node_block(m.lattice, 1)},
      neighbors{neighbors_of(m, 0), neighbors_of(m, 1)} {}

void SolidRow::gather(int parity, int slot, int count, SystemBuffer& out) const {
  const bool cut = row_cut[slot / row_stride(model.lattice)];
  for (int begin = 0; begin < count; begin += kSpareSlots) {
    const auto group = std::size_t((slot + begin) / kGroup);
    const Around found = std::max(model.around[group], model.around[group + 1]);
    if (found == Around::kNothing)
      for (int i = begin; i < begin + kSpareSlots; i++) out.set(i, {});
    else
      gather_sixteen(*this, parity, slot + begin, begin, cut, cut || found == Around::kSprings, out);
  }
}

}  // namespace turgor::lattice
