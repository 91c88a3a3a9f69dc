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

ListedNodes list_nodes(const Model& model, std::span<const std::uint8_t> row_cut,
                       std::span<const int> in_contact) {
  const Lattice& l = model.anatomy.lattice;
  ListedNodes nodes{
      .is_listed = std::vector<std::uint8_t>(model.anatomy.inverse_mass.size()), .slots = {}, .of_color = {}};
  const auto list = [&](int slot) {
    if (model.anatomy.inverse_mass[std::size_t(slot)] > 0) nodes.is_listed[std::size_t(slot)] = 1;
  };
  // skin, contacts and cut rows
  for (const int slot : model.anatomy.skin.nodes) list(slot);
  for (const int slot : in_contact) list(slot);
  for (std::size_t row = 0; row < row_cut.size(); row++)
    for (int n = 0; row_cut[row] && n < 2 * l.half; n++) list(int(row) * 2 * l.half + n);
  // loose edges
  for (std::size_t group = 0; group < model.vbd.incident_elements.size(); group++)
    for (int n = 0; model.vbd.incident_elements[group] == IncidentElements::kSprings && n < kGroup; n++)
      if (const int slot = int(group) * kGroup + n; has_loose_edge(model, slot)) list(slot);
  // by color
  std::vector<int> groups;
  const ColorBegin of_color = groups_by_colors(l, model.anatomy.free_runs, groups);
  for (int color = 0; color < kColorCount; color++) {
    nodes.of_color.begin[color] = int(nodes.slots.size());
    for (int g = of_color.begin[color]; g < of_color.begin[color + 1]; g++)
      for (int slot = groups[std::size_t(g)]; slot < groups[std::size_t(g)] + kGroup; slot++)
        if (nodes.is_listed[std::size_t(slot)]) nodes.slots.push_back(slot);
  }
  nodes.of_color.begin[kColorCount] = int(nodes.slots.size());
  return nodes;
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
