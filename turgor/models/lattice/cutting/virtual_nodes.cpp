#include "turgor/models/lattice/cutting/virtual_nodes.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>

#include "turgor/core/disjoint_sets.hpp"
#include "turgor/core/sort_unique.hpp"

namespace turgor::lattice {

namespace {

/// The pieces around one node, joined where they share tissue.
struct AroundNode {
  Fragments& pieces;
  Int3 node;
  const CutCell* cell[8] = {};  // corner c of cell c is the node
  int first[9] = {};            // of its pieces, among those around the node
  std::vector<int> group;       // of each piece

  AroundNode(Fragments& p, Int3 n) : pieces(p), node(n) {
    for (int c = 0; c < 8; c++) {
      const Int3 corner = node - cell_corner(c), last = p.fine.cells.size - Int3{2, 2, 2};
      const bool inside = corner == min(max(corner, Int3{0, 0, 0}), last);
      cell[c] = inside ? find_cell(p, node_slot(p.fine.cells, corner)) : nullptr;
      first[c + 1] = first[c] + (cell[c] ? cell[c]->fragment_count : 0);
    }
    group.resize(std::size_t(first[8]));
    std::iota(group.begin(), group.end(), 0);
    for (int a = 0; a < 8; a++)
      for (int b = a + 1; b < 8; b++)
        if (cell[a] && cell[b]) {
          if (std::popcount(unsigned(a ^ b)) == 1) join_faces(a, b);
          if (has_thin(a) || has_thin(b)) join_thin(a, b);
        }
  }

  bool has_thin(int c) const {
    for (int p = 0; p < cell[c]->fragment_count; p++)
      if (is_thin(c, p)) return true;
    return false;
  }
  int label(int c, Int3 p) const {
    const FineLattice& f = pieces.fine;
    const Int3 local = p - first_of_cell(f, node - cell_corner(c));
    return pieces.label[cell[c]->places + std::size_t(place_in_cell(f, local))];
  }
  bool is_thin(int c, int piece) const {
    return pieces.pieces[std::size_t(cell[c]->first_fragment + piece)].thin;
  }
  /// By the area that they share in the face between two cells: three fine nodes of a square of it, or fewer
  /// that a blade parted from the others. Where a blade ends in the edge of a cell, pieces that touch in that
  /// edge alone are not one.
  void join_faces(int a, int b) {
    const Int3 low = shared_places(a, b).first;
    Int3 side[2];
    int sides = 0;
    for (int axis = 0; axis < 3; axis++)
      if ((a >> axis & 1) == (b >> axis & 1)) side[sides++] = kFamilies[std::size_t(axis)];
    for (int j = 0; j < dot(side[1], pieces.fine.parts); j++)
      for (int i = 0; i < dot(side[0], pieces.fine.parts); i++) {
        const Int3 p = low + side[0] * i + side[1] * j;
        join_square(a, b, {p, p + side[0], p + side[1], p + side[0] + side[1]});
      }
  }
  void join_square(int a, int b, const std::array<Int3, 4>& corners) {
    int in_a[4], in_b[4];
    for (std::size_t c = 0; c < 4; c++) in_a[c] = label(a, corners[c]), in_b[c] = label(b, corners[c]);
    for (std::size_t c = 0; c < 4; c++) {
      if (in_a[c] < 0 || in_b[c] < 0) continue;
      int alike = 0;
      bool cut = false;  // between here and another corner: then there is tissue up to the blade
      for (std::size_t d = 0; d < 4; d++) {
        const bool same = in_a[d] == in_a[c] && in_b[d] == in_b[c];
        alike += same;
        cut = cut || (!same && is_cut(a, corners[c], corners[d]));
      }
      if (alike >= 3 || cut) join_sets(group, first[a] + in_a[c], first[b] + in_b[c]);
    }
  }
  /// Is the edge between two fine nodes of a cell cut? False where there is no edge.
  bool is_cut(int c, Int3 p, Int3 q) const {
    const bool up = family_of(q - p) >= 0;
    const int family = up ? family_of(q - p) : family_of(p - q);
    if (family < 0) return false;
    const FineLattice& f = pieces.fine;
    const Int3 local = (up ? p : q) - first_of_cell(f, node - cell_corner(c));
    return pieces.cut[cell[c]->places + std::size_t(place_in_cell(f, local))] >> family & 1;
  }
  /// Pieces without area, by the fine nodes that both cells have.
  void join_thin(int a, int b) {
    const auto [low, high] = shared_places(a, b);
    for (int k = low.z; k <= high.z; k++)
      for (int j = low.y; j <= high.y; j++)
        for (int i = low.x; i <= high.x; i++)
          if (const int la = label(a, {i, j, k}), lb = label(b, {i, j, k}); la >= 0 && lb >= 0)
            if (is_thin(a, la) || is_thin(b, lb)) join_sets(group, first[a] + la, first[b] + lb);
  }
  /// The fine nodes that two cells share: lowest and highest.
  std::pair<Int3, Int3> shared_places(int a, int b) const {
    const Int3 at = first_of_cell(pieces.fine, node);
    Int3 low = at, high = at;
    for (int axis = 0; axis < 3; axis++) {
      if ((a >> axis & 1) != (b >> axis & 1)) continue;
      (a >> axis & 1 ? low : high)[axis] +=
          a >> axis & 1 ? -pieces.fine.parts[axis] : pieces.fine.parts[axis];
    }
    return {low, high};
  }
  /// The group that the node itself belongs to, -1 when it is air.
  int own_group() {
    for (int c = 0; c < 8; c++)
      if (cell[c])
        if (const int l = label(c, first_of_cell(pieces.fine, node)); l >= 0)
          return root_of(group, first[c] + l);
    return -1;
  }
};

/// Gives each group of pieces around a node that the node does not lie in a copy of it. Air has no group of
/// its own.
void copy_node(Fragments& out, Int3 node) {
  AroundNode around(out, node);
  const int own = around.own_group();
  std::vector<int> copy_of(std::size_t(around.first[8]), -1);
  for (int c = 0; c < 8; c++)
    for (int n = around.first[c]; n < around.first[c + 1]; n++) {
      const int group = root_of(around.group, n);
      if (group == own) continue;
      int& copy = copy_of[std::size_t(group)];
      if (copy < 0) {
        copy = slot_count(out.fine.cells) + int(out.virtual_nodes.size());
        out.virtual_nodes.push_back(
            {.slot = node_slot(out.fine.cells, node), .place = std::numeric_limits<std::uint64_t>::max()});
      }
      Fragment& piece = out.pieces[std::size_t(around.cell[c]->first_fragment + n - around.first[c])];
      piece.corner[std::size_t(c)] = copy;
      VirtualNode& made = out.virtual_nodes[std::size_t(copy - slot_count(out.fine.cells))];
      made.place = std::min(made.place, piece.place);
    }
}

}  // namespace

void make_copies(Fragments& out) {
  std::vector<int> nodes;  // slots
  for (const CutCell& cell : out.cells) {
    if (!cell.is_cut) continue;
    const int parity = slot_node(out.fine.cells, cell.slot).x & 1;
    for (int c = 0; c < 8; c++)
      nodes.push_back(cell.slot + slot_offset(out.fine.cells, cell_corner(c), parity));
  }
  sort_unique(nodes);
  for (const int slot : nodes) copy_node(out, slot_node(out.fine.cells, slot));
}

}  // namespace turgor::lattice
