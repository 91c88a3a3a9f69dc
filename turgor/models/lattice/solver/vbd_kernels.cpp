#include "turgor/models/lattice/solver/vbd_kernels.hpp"

#include <algorithm>

namespace turgor::lattice {

VbdRules vbd_rules(const Model& model) {
  const Lattice& l = model.anatomy.lattice;
  VbdRules rules{.neighbors = {neighbors_of(model, 0), neighbors_of(model, 1)},
                 .block = {node_block(l, 0), node_block(l, 1)},
                 .solid = solid_law(l.spacing, model.params.tissue.poisson),
                 .rest_volume = model.springs.rest_volume,
                 .volume_scale = model.springs.volume_scale};
  for (int n = 0; n < kCellCorners; n++)
    for (int e = 0; e < kNeighborCount; e++)
      if (cell_contains(n, neighbor_offset(e))) rules.covering_cells[e] |= std::uint8_t(1u << n);
  return rules;
}

VirtualNodeOrdering virtual_node_ordering(const Model& model, const CutElements& elements) {
  VirtualNodeOrdering ordering;
  for (int color = 0; color < kColorCount; color++) {
    ordering.virtual_nodes_of_color.begin[color] = int(ordering.virtual_nodes.size());
    for (const ElementNode& virtual_node : elements.virtual_nodes)
      if (color_of(slot_node(model.anatomy.lattice, virtual_node.slot)) == color)
        ordering.virtual_nodes.push_back(virtual_node);
  }
  ordering.virtual_nodes_of_color.begin[kColorCount] = int(ordering.virtual_nodes.size());
  return ordering;
}

}  // namespace turgor::lattice
