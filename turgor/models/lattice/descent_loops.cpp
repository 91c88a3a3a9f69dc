#include "turgor/models/lattice/descent_loops.hpp"

#include <algorithm>

namespace turgor::lattice {

DescentRules descent_rules(const Model& model) {
  const Lattice& l = model.lattice;
  DescentRules rules{.neighbours = {neighbours_of(model, 0), neighbours_of(model, 1)},
                     .block = {node_block(l, 0), node_block(l, 1)},
                     .solid = solid_law(l.step, model.params.tissue.poisson),
                     .rest_volume = model.rest_volume,
                     .volume_scale = model.volume_scale};
  for (int n = 0; n < kCellCorners; n++) {
    rules.edges_from[n] = edges_from_corner(n);
    for (int e = 0; e < kNeighbourCount; e++)
      if (cell_holds(n, neighbour_offset(e))) rules.holders[e] |= std::uint8_t(1u << n);
  }
  return rules;
}

CopySchedule copy_schedule(const Model& model, const State& state) {
  CopySchedule schedule;
  for (int colour = 0; colour < kColourCount; colour++) {
    schedule.copies_of.begin[colour] = int(schedule.copies.size());
    for (const PartNode& copy : state.parts.copies)
      if (colour_of(slot_node(model.lattice, copy.slot)) == colour) schedule.copies.push_back(copy);
  }
  schedule.copies_of.begin[kColourCount] = int(schedule.copies.size());
  return schedule;
}

}  // namespace turgor::lattice
