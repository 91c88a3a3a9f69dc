// What the pieces of a cut body are asked while it is drawn among voxels: which piece holds a point, and
// where a corner is. Over plain pointers, for the CPU and for threads of a GPU.
#pragma once

#include "turgor/models/lattice/cutting/extrapolate.hpp"
#include "turgor/models/lattice/cutting/fragments.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"
#include "turgor/models/lattice/resample/raster.hpp"

namespace turgor::lattice {

/// Pieces and what was cut, on one side of the bus.
struct FragmentView {
  FineLattice fine;
  const CutCell* cells;
  const Fragment* pieces;
  const VirtualNode* virtual_nodes;
  const FitTerm* sources;
  const GhostFragment* ghosts;
  int first_ghost_place;  // of places by slot, then of copies, then of the corners of guests
  const std::int16_t* label;
  KeyTable edge_index;
  const CutEdge* edges;            // State::cut_edges
  const VirtualNodeShift* shifts;  // State::copies; null where no copy is solved for
};

inline FragmentView view(const Fragments& pieces, const State& state) {
  const bool solved = state.virtual_nodes.size() == pieces.virtual_nodes.size();
  return {.fine = pieces.fine,
          .cells = pieces.cells.data(),
          .pieces = pieces.pieces.data(),
          .virtual_nodes = pieces.virtual_nodes.data(),
          .sources = pieces.sources.data(),
          .ghosts = pieces.ghosts.data(),
          .first_ghost_place = slot_count(pieces.fine.cells) + int(pieces.virtual_nodes.size()),
          .label = pieces.label.data(),
          .edge_index = pieces.edge_index.table(),
          .edges = state.cut_edges.data(),
          .shifts = solved ? state.virtual_nodes.data() : nullptr};
}

TURGOR_HD inline Crossing crossing(const FragmentView& pieces, Int3 a, Int3 b) {
  const Int3 way = b - a;
  const bool swapped = way.x < 0 || way.y < 0 || way.z < 0;
  const Int3 lower = swapped ? b : a;
  const int index =
      pieces.edge_index.find(fine_edge_key(pieces.fine, lower, family_of(swapped ? -way : way)));
  if (index < 0) return {};
  const CutEdge& edge = pieces.edges[index];
  return {.edge = &edge,
          .fraction = swapped ? 1 - edge.fraction : edge.fraction,
          .rightward = (edge.rightward != 0) != swapped};
}

/// Corner levels of a tetrahedron whose corners have two labels, so that they vanish where its edges are cut:
/// positive where the label is that of the first.
TURGOR_HD inline std::array<Real, 4> two_sides(const FragmentView& pieces, const std::array<Int3, 4>& nodes,
                                               const std::array<int, 4>& label) {
  std::array<Real, 4> level{};
  std::array<int, 4> count{};
  const auto cut = [&](std::size_t a, std::size_t b) {
    const Crossing found = crossing(pieces, nodes[a], nodes[b]);
    const Real least = Real(0.01), most = Real(0.99);
    if (!found.edge) return Real(0.5);  // beyond the tip
    return found.fraction < least ? least : found.fraction > most ? most : found.fraction;
  };
  level[0] = 1;
  for (std::size_t b = 1; b < 4; b++)  // across from the first, then back
    if (label[b] != label[0]) level[b] = 1 - 1 / cut(0, b);
  for (std::size_t a = 1; a < 4; a++) {
    if (label[a] != label[0]) continue;
    for (std::size_t b = 1; b < 4; b++)
      if (label[b] != label[0]) level[a] -= level[b] * cut(a, b) / (1 - cut(a, b)), count[a]++;
    level[a] /= Real(count[a] > 1 ? count[a] : 1);
  }
  return level;
}

/// Which piece of its cell, or guest after its own, holds a point, from its coordinates in the cell, 0 to 1;
/// -1 where there is none.
TURGOR_HD inline int fragment_at(const FragmentView& pieces, const CutCell& cell, Vec3 at) {
  if (cell.fragment_count + cell.ghost_count < 2) return cell.fragment_count - 1;
  const FineLattice& f = pieces.fine;
  Vec3 in_part;
  Int3 part;
  for (int axis = 0; axis < 3; axis++) {
    const Real x = at[axis] * Real(f.parts[axis]);
    const int most = f.parts[axis] - 1, floor = int(std::floor(x));
    part[axis] = floor < 0 ? 0 : floor > most ? most : floor;
    const Real beyond = x - Real(part[axis]);
    in_part[axis] = beyond < 0 ? Real(0) : beyond > 1 ? Real(1) : beyond;
  }
  const int tet = kuhn_tet_at(in_part);
  const std::array<Int3, 4> corners = kuhn_corners(part, tet);
  const std::array<Real, 4> weight = path_weights(tet, in_part);
  std::array<int, 4> label{};
  bool two = true;
  int other = -1;
  for (std::size_t n = 0; n < 4; n++) {
    label[n] = piece_of(pieces.label, cell, place_in_cell(f, corners[n]));
    if (label[n] == label[0]) continue;
    two &= other < 0 || label[n] == other;
    other = label[n];
  }
  if (other < 0) return label[0];
  if (!two) {
    std::size_t most = 0;
    for (std::size_t n = 1; n < 4; n++)
      if (weight[most] < weight[n]) most = n;
    return label[most];
  }
  std::array<Int3, 4> nodes;
  for (std::size_t n = 0; n < 4; n++) nodes[n] = first_of_cell(f, slot_node(f.cells, cell.slot)) + corners[n];
  const std::array<Real, 4> level = two_sides(pieces, nodes, label);
  Real sum = 0;
  for (std::size_t n = 0; n < 4; n++) sum += level[n] * weight[n];
  return sum >= 0 ? label[0] : other;
}

/// Is an edge of the lattice between two corners of this cell cut? `cut`: State::cut.
TURGOR_HD inline bool has_cut_edge(const std::uint8_t* cut, const Lattice& lattice, int slot) {
  const int parity = slot_node(lattice, slot).x & 1;
  int found = 0;
  for (int n = 0; n < kCellCorners; n++)
    found |= cut[slot + slot_offset(lattice, cell_corner(n), parity)] & edges_from(n);
  return found != 0;
}

/// Did a blade go between two neighbours, the second of which lies `way` from the first?
TURGOR_HD inline bool is_parted(const std::uint8_t* cut, const Lattice& l, int beside, int behind, Int3 way) {
  const bool up = family_of(way) >= 0;
  if (const int family = up ? family_of(way) : family_of(-way); family >= 0)
    return cut[up ? beside : behind] >> family & 1;
  return has_cut_edge(cut, l, node_slot(l, slot_node(l, beside) + min(way, Int3{0, 0, 0})));
}

/// Displacement of a corner of a piece: of a node, of a copy, or of air beside the body, which follows it
/// [m]. `body` as follow_neighbours asks for it, as it is cut now. Sources are nodes of tissue or copies that
/// bear some, whose own sources are nodes.
template <int kDeep = 3, class Body>
TURGOR_HD Vec3 corner_displacement(const Body& body, const FragmentView& pieces, int corner) {
  const Lattice& l = pieces.fine.cells;
  const int slots = slot_count(l);
  const VirtualNode* copy = corner < slots ? nullptr : &pieces.virtual_nodes[corner - slots];
  if (copy != nullptr && copy->bears && pieces.shifts != nullptr) {
    const VirtualNodeShift& u = pieces.shifts[corner - slots];
    return {u.x, u.y, u.z};
  }
  if (copy == nullptr || copy->source_count == 0) {  // a crumb without a node of its own goes with its node
    const int slot = copy ? copy->slot : corner;
    return body.is_solid(slot) ? body.u(slot) : extrapolate_from_neighbors(l, body, slot);
  }
  Vec3 sum;
  if constexpr (kDeep > 0)
    for (int s = copy->first; s < copy->first + copy->source_count; s++)
      sum +=
          corner_displacement<kDeep - 1>(body, pieces, pieces.sources[s].corner) * pieces.sources[s].weight;
  return sum;
}

/// guest_displacement, of any body.
template <class Body>
TURGOR_HD Vec3 ghost_displacement(const Body& body, const FragmentView& pieces, int ghost, int corner) {
  const Lattice& l = pieces.fine.cells;
  const GhostFragment& g = pieces.ghosts[ghost];
  const CutCell& home = pieces.cells[g.cell];
  const Int3 at = slot_node(l, g.slot) - slot_node(l, home.slot) + cell_corner(corner);
  const std::array<Real, 8> weight = trilinear(Vec3(at));
  Vec3 sum;
  for (std::size_t c = 0; c < 8; c++)
    if (weight[c] != 0)
      sum += corner_displacement(body, pieces, pieces.pieces[home.first_fragment + g.piece].corner[c]) *
             weight[c];
  return sum;
}

/// Whose places the corners of a piece of a cell are, or of a guest after its own.
TURGOR_HD inline std::array<int, 8> placed_corners(const FragmentView& pieces, const CutCell& cell,
                                                   int piece) {
  if (piece < cell.fragment_count) return pieces.pieces[cell.first_fragment + piece].corner;
  const int ghost = cell.first_ghost + piece - cell.fragment_count;
  std::array<int, 8> corners{};
  for (int c = 0; c < 8; c++) corners[std::size_t(c)] = pieces.first_ghost_place + 8 * ghost + c;
  return corners;
}

/// The slots of a cell's corners.
TURGOR_HD inline std::array<int, 8> cell_slots(const Lattice& l, int slot, int parity) {
  std::array<int, 8> slots{};
  for (int c = 0; c < 8; c++) slots[std::size_t(c)] = slot + slot_offset(l, cell_corner(c), parity);
  return slots;
}

/// Which places of the CT lie in a piece of a cell, or with a guest, and are tissue still.
struct TissueOfFragment {
  const FragmentView& pieces;
  const std::uint8_t* removed;  // State::removed; null where nothing is
  const CutCell* cut;           // null: a cell in one piece
  int piece;
  Vec3d first, size;  // of the cell, in the CT
  const std::array<int, 8>& slots;

  TURGOR_HD bool operator()(Vec3 at) const {
    const Vec3d d = Vec3d(at) - first;
    const Vec3 in_cell(Vec3d{d.x / size.x, d.y / size.y, d.z / size.z});
    if (cut && fragment_at(pieces, *cut, in_cell) != piece) return false;
    return removed == nullptr || !is_gone(in_cell);
  }

 private:
  /// More than half of its weight on removed nodes: a place that left the body.
  TURGOR_HD bool is_gone(Vec3 at) const {
    const int tet = kuhn_tet_at(at);
    const std::array<Int3, 4> nodes = kuhn_corners({0, 0, 0}, tet);
    const std::array<float, 4> weight = path_weights(tet, at);
    float gone = 0;
    for (std::size_t n = 0; n < 4; n++)
      if (removed[slots[std::size_t(nodes[n].x + 2 * nodes[n].y + 4 * nodes[n].z)]]) gone += weight[n];
    return gone > 0.5f;
  }
};

}  // namespace turgor::lattice
