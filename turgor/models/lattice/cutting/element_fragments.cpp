#include "turgor/models/lattice/cutting/element_fragments.hpp"

#include <algorithm>
#include <vector>

#include "turgor/core/sort_unique.hpp"
#include "turgor/models/lattice/cutting/crack_tips.hpp"
#include "turgor/models/lattice/cutting/fragment_shares.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"

namespace turgor::lattice {

namespace {

using Corners = std::array<int, 8>;

/// True if a cell around a node is whole, and no cut elements replace it.
bool is_in_whole_cell(const Model& model, const Cuts& cuts, const Fragments& fragments, int node) {
  const Lattice& l = model.anatomy.lattice;
  for (int n = 0; n < kCellCorners; n++) {
    const Int3 cell = slot_node(l, node) - cell_corner(n);
    if (!contains(l, cell) || !contains(l, cell + Int3{1, 1, 1})) continue;
    const int slot = node_slot(l, cell);
    if (!(model.anatomy.cell_young[std::size_t(slot)] > 0)) continue;
    const CutCell* cut = find_cell(fragments, slot);
    if (cut && is_cut_cell(model, cuts, fragments, *cut)) continue;
    bool removed = false;
    for (int c = 0; c < kCellCorners; c++)
      removed |= is_removed_tissue(model, cuts, slot + slot_offset(l, cell_corner(c), cell.x & 1));
    if (!removed) return true;
  }
  return false;
}

/// Corners of all elements of cut cells: of slivers, and of others.
struct ElementCorners {
  std::vector<Corners> slivers, others;
};
ElementCorners element_corners(const Model& model, const Cuts& cuts, const Fragments& fragments) {
  constexpr Real kSliver = 0.01;  // fraction of a cell
  ElementCorners found;
  const auto add = [&](const Corners& corners, Real fraction) {
    (fraction < kSliver ? found.slivers : found.others).push_back(corners);
  };
  for (const CutCell& cell : fragments.cells) {
    if (!is_cut_cell(model, cuts, fragments, cell)) continue;
    const auto fragment = [&](int n) -> const Fragment& {
      return fragments.all[std::size_t(cell.first_fragment + n)];
    };
    // fragments
    const Shares shares = shares_of(fragments, cuts, cell);
    for (int p = 0; p < cell.fragment_count; p++)
      if (can_be_element(model, cuts, fragments, fragment(p)))
        add(fragment(p).corner, shares.parted[std::size_t(p)] * shares.of[std::size_t(p)]);
    // bridges at crack tips
    for (int t = 0; t < cell.tip_count; t++) {
      const CrackTip& tip = fragments.tips[std::size_t(cell.first_tip + t)];
      add(bridge_corners(model, cuts, fragments, cell, tip),
          shares.bridges[std::size_t(t)] *
              (shares.of[std::size_t(tip.left)] + shares.of[std::size_t(tip.right)]));
    }
  }
  return found;
}

}  // namespace

bool has_cut_elements(const Model& model) {
  return model.params.tissue.law == TissueLaw::kSolid && model.params.solver.method == Method::kVbd;
}

bool is_cut_cell(const Model& model, const Cuts& cuts, const Fragments& fragments, const CutCell& cell) {
  if (!(model.anatomy.cell_young[std::size_t(cell.slot)] > 0)) return false;
  // several fragments, a cut edge, or a virtual node, and no removed node
  bool other = cell.fragment_count > 1 || has_cut_edge(cuts, model.anatomy.lattice, cell.slot),
       removed = false;
  const int parity = slot_node(model.anatomy.lattice, cell.slot).x & 1;
  for (int n = 0; n < kCellCorners; n++) {
    const int slot = cell.slot + slot_offset(model.anatomy.lattice, cell_corner(n), parity);
    removed |= is_removed_tissue(model, cuts, slot);
    for (int p = cell.first_fragment; p < cell.first_fragment + cell.fragment_count; p++)
      other |= fragments.all[std::size_t(p)].corner[std::size_t(n)] != slot;
  }
  return other && !removed;
}

bool can_be_element(const Model& model, const Cuts& cuts, const Fragments& fragments,
                    const Fragment& fragment) {
  if (fragment.excised) return false;
  const int slots = slot_count(model.anatomy.lattice);
  const bool with_rim = !model.anatomy.cell_center.empty();
  const auto bears = [&](int slot) {
    return is_solid(model, cuts, slot) || (with_rim && !is_body(model.anatomy.tissue[std::size_t(slot)]));
  };
  const auto stays = [&](int slot) {
    return with_rim ? !is_removed_tissue(model, cuts, slot) : was_solid(model, cuts, slot);
  };
  return std::all_of(fragment.corner.begin(), fragment.corner.end(), [&](int corner) {
    if (corner < slots) return bears(corner);
    const VirtualNode& virtual_node = fragments.virtual_nodes[std::size_t(corner - slots)];
    return stays(virtual_node.slot) && virtual_node.term_count > 0;
  });
}

std::array<int, 8> bridge_corners(const Model& model, const Cuts& cuts, const Fragments& fragments,
                                  const CutCell& cell, const CrackTip& tip) {
  const auto fragment_of = [&](int n) -> const Fragment& {
    return fragments.all[std::size_t(cell.first_fragment + n)];
  };
  if (!can_be_element(model, cuts, fragments, fragment_of(tip.left)) ||
      !can_be_element(model, cuts, fragments, fragment_of(tip.right)))
    return corners_of(model, fragments, cell.slot, -1);
  const Vec3d low(in_body(fragments.fine.cells, slot_node(fragments.fine.cells, cell.slot)));
  std::array<int, 8> corners;
  for (int n = 0; n < kCellCorners; n++)
    corners[std::size_t(n)] =
        fragment_of(tip.plane.signed_distance(low + Vec3d(cell_corner(n))) >= 0 ? tip.right : tip.left)
            .corner[std::size_t(n)];
  return corners;
}

bool has_all_unknowns(const Fragments& fragments, const std::array<int, 8>& corners) {
  const int slots = slot_count(fragments.fine.cells);
  return std::all_of(corners.begin(), corners.end(), [&](int corner) {
    return corner < slots || fragments.virtual_nodes[std::size_t(corner - slots)].has_unknowns;
  });
}

void mark_virtual_nodes_with_unknowns(const Model& model, const Cuts& cuts, Fragments& fragments) {
  if (!has_cut_elements(model)) return;
  const int slots = slot_count(model.anatomy.lattice);
  const auto mark = [&](const Corners& corners) {
    for (const int corner : corners)
      if (corner >= slots) fragments.virtual_nodes[std::size_t(corner - slots)].has_unknowns = true;
  };
  // elements that are no slivers, and the nodes of the lattice that they hold
  const ElementCorners elements = element_corners(model, cuts, fragments);
  std::vector<int> held;
  for (const Corners& corners : elements.others) {
    mark(corners);
    for (const int corner : corners)
      if (corner < slots) held.push_back(corner);
  }
  sort_unique(held);
  // slivers that alone hold a node of the lattice
  for (const Corners& corners : elements.slivers)
    if (std::any_of(corners.begin(), corners.end(), [&](int corner) {
          return corner < slots && !std::binary_search(held.begin(), held.end(), corner) &&
                 !is_in_whole_cell(model, cuts, fragments, corner);
        }))
      mark(corners);
}

}  // namespace turgor::lattice
