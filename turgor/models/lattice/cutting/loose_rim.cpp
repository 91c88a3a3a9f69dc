#include "turgor/models/lattice/cutting/loose_rim.hpp"

#include "turgor/models/lattice/mechanics/cells.hpp"

namespace turgor::lattice {

void remove_loose_rim(const Model& model, Cuts& cuts) {
  if (model.anatomy.cell_center.empty()) return;
  const Lattice& l = model.anatomy.lattice;
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
    bool held = false;
    for (int n = 0; n < kCellCorners; n++) held = held || is_whole_cell(model, cuts, node - cell_corner(n));
    if (!held) cuts.removed[std::size_t(slot)] = 1;
  }
}

}  // namespace turgor::lattice
