#include "turgor/models/lattice/descent_loops.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"

namespace turgor::lattice {

namespace {

DescentRules descent_rules(const Model& model) {
  const Lattice& l = model.lattice;
  DescentRules rules{.half = l.half,
                     .neighbours = {neighbours_of(model, 0), neighbours_of(model, 1)},
                     .block = {node_block(l, 0), node_block(l, 1)},
                     .solid = solid_law(l.step, model.params.tissue.poisson),
                     .rest_volume = model.rest_volume,
                     .volume_scale = model.volume_scale};
  std::copy(kTetsAround.begin(), kTetsAround.end(), rules.tets);
  for (int n = 0; n < kCellCorners; n++) {
    rules.edges_from[n] = edges_from_corner(n);
    for (int e = 0; e < kNeighbourCount; e++)
      if (cell_holds(n, neighbour_offset(e))) rules.holders[e] |= std::uint8_t(1u << n);
  }
  return rules;
}

}  // namespace

DescentSchedule descent_schedule(const Model& model) {
  DescentSchedule schedule;
  schedule.moving_of = groups_by_colours(model.lattice, model.moving, schedule.moving);
  return schedule;
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

DescentView descent_view(const Model& model, const DescentSchedule& schedule, const CopySchedule& copies,
                         State& state, const Inputs& inputs, double dt) {
  TURGOR_ASSERT(model.params.solver.method == Method::kDescent, "the model was made for descent");
  const Skin& skin = model.skin;
  const bool has_skin = !skin.triangles.empty(), solid = model.params.tissue.law == TissueLaw::kSolid;
  return {.rules = descent_rules(model),
          .nodes = node_arrays(model, state),
          .inertia = Inertia(model, state, inputs, dt),
          .young = solid ? model.cell_young.data() : nullptr,
          .row_cut = state.row_cut.data(),
          .moving = schedule.moving.data(),
          .moving_of = schedule.moving_of,
          .skin_nodes = has_skin ? skin.nodes.data() : nullptr,
          .corner_begin = skin.corner_begin.data(),
          .skin_row_begin = skin.row_begin.data(),
          .lanes_begin = skin.lanes_begin.data(),
          .pull = skin.pull.data(),
          .corners = skin.corners.data(),
          .skin_cut = state.skin_cut.data(),
          .parts = PartForces(model, state).elements,
          .part_nodes = state.parts.nodes.data(),
          .copies = copies.copies.data(),
          .part_node_count = int(state.parts.nodes.size()),
          .copies_of = copies.copies_of,
          .contacts = inputs.contacts.data(),
          .contact_count = int(inputs.contacts.size())};
}

}  // namespace turgor::lattice
