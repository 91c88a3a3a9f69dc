#include "turgor/models/lattice/cutting/loose_rim.hpp"

#include <algorithm>

#include "turgor/core/sort_unique.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"

namespace turgor::lattice {

void remove_loose_rim(const Model& model, State& state) {
  if (model.anatomy.cell_center.empty()) return;
  const Lattice& l = model.anatomy.lattice;
  Cuts& cuts = state.cuts;
  // rim nodes of cut elements
  std::vector<int> held_by_element;
  for (const CutCellElement& element : state.cut_elements.cells)
    for (const int corner : element.corner)
      if (corner < slot_count(l) && is_rim(model, corner)) held_by_element.push_back(corner);
  sort_unique(held_by_element);
  const int stride = row_stride(l);
  for (int slot = 0; slot < slot_count(l); slot++) {
    // skip rows without cuts
    if (slot % stride == 0 && std::size_t(slot / stride) < cuts.row_cut.size() &&
        !cuts.row_cut[std::size_t(slot / stride)]) {
      slot += stride - 1;
      continue;
    }
    if (!is_rim(model, slot) || cuts.removed[std::size_t(slot)]) continue;
    // whole cells around the node
    const Int3 node = slot_node(l, slot);
    bool held = std::binary_search(held_by_element.begin(), held_by_element.end(), slot);
    for (int n = 0; n < kCellCorners; n++) held = held || is_whole_cell(model, cuts, node - cell_corner(n));
    if (!held) cuts.removed[std::size_t(slot)] = kRemoved;
  }
}

}  // namespace turgor::lattice
