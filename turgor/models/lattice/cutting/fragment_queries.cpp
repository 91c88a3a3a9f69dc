// What is asked of the pieces of a cut body: where an edge is cut, which piece holds a point, where a corner
// is.
#include <algorithm>

#include "turgor/models/lattice/cutting/fragment_view.hpp"

namespace turgor::lattice {

namespace {

/// As it is cut now, for follow_neighbours.
struct CutBody {
  const Model& model;
  const State& state;

  bool is_solid(int slot) const { return lattice::is_solid(model, state, slot); }
  Vec3 u(int slot) const { return state.u[std::size_t(slot)]; }
  bool is_parted(int beside, int behind, Int3 way) const {
    return lattice::is_parted(state.cut.data(), model.lattice, beside, behind, way);
  }
};

/// The same body, which writes down whose displacement is asked for.
struct AskedBody : CutBody {
  std::vector<int>& asked;

  Vec3 u(int slot) const {
    asked.push_back(slot);
    return {};
  }
};

}  // namespace

Crossing crossing(const Fragments& pieces, const State& state, Int3 a, Int3 b) {
  return crossing(view(pieces, state), a, b);
}

int fragment_at(const Fragments& pieces, const State& state, const CutCell& cell, Vec3 at) {
  return fragment_at(view(pieces, state), cell, at);
}

Vec3 corner_displacement(const Model& model, const State& state, const Fragments& pieces, int corner) {
  return corner_displacement(CutBody{model, state}, view(pieces, state), corner);
}

void add_nodes_behind(const Model& model, const State& state, const Fragments& pieces, int corner,
                      std::vector<int>& nodes) {
  corner_displacement(AskedBody{{model, state}, nodes}, view(pieces, state), corner);
}

Vec3 ghost_displacement(const Model& model, const State& state, const Fragments& pieces, int ghost,
                        int corner) {
  return ghost_displacement(CutBody{model, state}, view(pieces, state), ghost, corner);
}

std::vector<SpecialCell> special_cells(const Model& model, const State& state, const Fragments& pieces) {
  std::vector<SpecialCell> special;
  for (const CutCell& cell : pieces.cells) {
    const auto own = corners_of(model, pieces, cell.slot, -1);
    if (cell.fragment_count != 1 || cell.ghost_count > 0 || corners_of(model, pieces, cell.slot, 0) != own)
      special.push_back({cell.slot, int(&cell - pieces.cells.data())});
  }
  if (state.removed_nodes == 0) return special;
  const Lattice& l = model.lattice;
  for (std::size_t s = 0; s < model.tissue.size(); s++) {
    if (state.removed[s] == 0 || !is_body(model.tissue[s])) continue;
    const Int3 node = slot_node(l, int(s));
    for (int c = 0; c < 8; c++) {
      const Int3 cell = node - cell_corner(c), beyond = cell + Int3{1, 1, 1};
      if (!contains(l, cell) || !contains(l, beyond)) continue;
      const int slot = node_slot(l, cell);
      special.push_back({slot, pieces.cell_index.find(std::uint64_t(slot))});
    }
  }
  const auto before = [](const SpecialCell& a, const SpecialCell& b) { return a.slot < b.slot; };
  const auto same = [](const SpecialCell& a, const SpecialCell& b) { return a.slot == b.slot; };
  std::sort(special.begin(), special.end(), before);
  special.erase(std::unique(special.begin(), special.end(), same), special.end());
  return special;
}

std::array<int, 8> corners_of(const Model& model, const Fragments& pieces, int slot, int piece) {
  if (piece >= 0)
    if (const CutCell* cell = find_cell(pieces, slot); cell && piece < cell->fragment_count)
      return pieces.pieces[std::size_t(cell->first_fragment + piece)].corner;
  std::array<int, 8> corners;
  const int parity = slot_node(model.lattice, slot).x & 1;
  for (int c = 0; c < 8; c++)
    corners[std::size_t(c)] = slot + slot_offset(model.lattice, cell_corner(c), parity);
  return corners;
}

}  // namespace turgor::lattice
