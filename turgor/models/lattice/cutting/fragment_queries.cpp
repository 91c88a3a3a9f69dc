// Queries on the fragments of a cut body on the host: cut of an edge, fragment that contains a point,
// displacement of a corner.
#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/cutting/fragment_view.hpp"

namespace turgor::lattice {

namespace {

/// Current cuts as the `body` of extrapolate_from_neighbors; derived types add displacements.
struct CutBody {
  const Model& model;
  const Cuts& cuts;

  bool is_solid(int slot) const { return has_displacement(model, cuts, slot); }
  bool is_separated(int near, int far, Int3 offset) const {
    return lattice::is_separated(cuts.cut.data(), model.anatomy.lattice, near, far, offset);
  }
};

/// Body with the current displacements.
struct DisplacedBody : CutBody {
  const VecField& displacement;

  Vec3 u(int slot) const { return displacement[std::size_t(slot)]; }
};

/// Body that records the nodes whose displacements are read.
struct SupportRecorder : CutBody {
  std::vector<int>& nodes;

  Vec3 u(int slot) const {
    nodes.push_back(slot);
    return {};
  }
};

}  // namespace

Crossing crossing(const Fragments& fragments, const Cuts& cuts, Int3 a, Int3 b) {
  return crossing(view(fragments, cuts), a, b);
}

int fragment_at(const Fragments& fragments, const Cuts& cuts, const CutCell& cell, Vec3 at) {
  return fragment_at(view(fragments, cuts), cell, at);
}

Vec3 corner_displacement(const Model& model, const State& state, const Fragments& fragments, int corner) {
  TURGOR_CHECK(
      is_index(corner, std::size_t(slot_count(fragments.fine.cells)) + fragments.virtual_nodes.size()),
      "a corner is a node or a virtual node");
  return corner_displacement(DisplacedBody{{model, state.cuts}, state.motion.u},
                             view(fragments, state.cuts, state.motion.virtual_u), corner);
}

void add_support_nodes(const Model& model, const Cuts& cuts,
                       std::span<const VirtualNodeDisplacement> virtual_u, const Fragments& fragments,
                       int corner, std::vector<int>& nodes) {
  corner_displacement(SupportRecorder{{model, cuts}, nodes}, view(fragments, cuts, virtual_u), corner);
}

Vec3 ghost_displacement(const Model& model, const State& state, const Fragments& fragments, int ghost,
                        int corner) {
  TURGOR_CHECK(is_index(ghost, fragments.ghosts.size()) && is_index(corner, 8), "a ghost has eight corners");
  return ghost_displacement(DisplacedBody{{model, state.cuts}, state.motion.u},
                            view(fragments, state.cuts, state.motion.virtual_u), ghost, corner);
}

std::vector<SpecialCell> special_cells(const Model& model, const Cuts& cuts, const Fragments& fragments) {
  // cells with several fragments, ghosts or virtual nodes
  std::vector<SpecialCell> special;
  for (const CutCell& cell : fragments.cells) {
    const auto own = corners_of(model, fragments, cell.slot, -1);
    if (cell.fragment_count != 1 || cell.ghost_count > 0 || corners_of(model, fragments, cell.slot, 0) != own)
      special.push_back({cell.slot, int(&cell - fragments.cells.data())});
  }
  if (cuts.removed_nodes == 0) return special;
  // cells with removed nodes
  const Lattice& l = model.anatomy.lattice;
  for (std::size_t s = 0; s < model.anatomy.tissue.size(); s++) {
    if (!is_body(model.anatomy.tissue[s]) || cuts.removed[s] == 0) continue;
    const Int3 node = slot_node(l, int(s));
    for (int c = 0; c < 8; c++) {
      const Int3 cell = node - cell_corner(c), beyond = cell + Int3{1, 1, 1};
      if (!contains(l, cell) || !contains(l, beyond)) continue;
      const int slot = node_slot(l, cell);
      special.push_back({slot, fragments.cell_index.find(std::uint64_t(slot))});
    }
  }
  // sorted, each cell once
  const auto before = [](const SpecialCell& a, const SpecialCell& b) { return a.slot < b.slot; };
  const auto same = [](const SpecialCell& a, const SpecialCell& b) { return a.slot == b.slot; };
  std::sort(special.begin(), special.end(), before);
  special.erase(std::unique(special.begin(), special.end(), same), special.end());
  return special;
}

std::array<int, 8> corners_of(const Model& model, const Fragments& fragments, int slot, int fragment) {
  if (fragment >= 0)
    if (const CutCell* cell = find_cell(fragments, slot); cell && fragment < cell->fragment_count)
      return fragments.all[std::size_t(cell->first_fragment + fragment)].corner;
  std::array<int, 8> corners;
  const int parity = slot_node(model.anatomy.lattice, slot).x & 1;
  for (int c = 0; c < 8; c++)
    corners[std::size_t(c)] = slot + slot_offset(model.anatomy.lattice, cell_corner(c), parity);
  return corners;
}

}  // namespace turgor::lattice
