// The fields of the lattice model, for its hash, its size in memory and recordings (core/field.hpp).
#pragma once

#include "turgor/core/field.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

/// What `cut` says decides skin_cut and row_cut; the cut edges of the fine lattice decide what cells fall
/// apart into and how a wound is drawn.
template <class S, class Visit>
requires std::is_same_v<std::remove_const_t<S>, State>
void visit_fields(S& s, const Visit& visit) {
  visit(Field{"displacement", "m", Axis::kSlot, kHashed | kRecorded}, s.u);
  visit(Field{"displacement_before", "m", Axis::kSlot}, s.u_before);
  visit(Field{"velocity", "m/s", Axis::kSlot, kHashed}, s.v);
  visit(Field{"cut", "", Axis::kSlot, kHashed | kRecorded}, s.cut);
  visit(Field{"removed", "", Axis::kSlot, kHashed | kRecorded}, s.removed);
  visit(Field{"row_cut", "", Axis::kRow, kRecorded}, s.row_cut);
  visit(Field{"skin_cut", "", Axis::kSkinTriangle, kRecorded}, s.skin_cut);
  visit(Field{"cut_edge", "", Axis::kCutEdge, kRecorded}, s.cut_edges);
  visit(Field{"crossed_cells", ""}, s.cut_samples);
  visit(Field{"copies", "m"}, s.virtual_nodes);
  visit(Field{"copies_before", "m"}, s.virtual_nodes_before);
  visit(Field{"cell_parts", ""}, s.parts.cells);
  visit(Field{"skin_parts", ""}, s.parts.skin);
  visit(Field{"part_nodes", ""}, s.parts.nodes);
  visit(Field{"part_copies", ""}, s.parts.virtual_nodes);
  visit(Field{"part_uses", ""}, s.parts.uses);
  visit(Field{"part_places", ""}, s.parts.places);
  visit(Field{"still", "", Axis::kRow}, s.sleep.still);
  visit(Field{"awake", "", Axis::kRow}, s.sleep.awake);
  visit(Field{"moved", "", Axis::kRow}, s.sleep.moved);
  visit(Field{"left_over", "N"}, s.residual_forces.layers);
}

/// Columns of a list of cut edges.
template <class Visit>
void visit_columns(const CutEdge*, const Visit& visit) {
  visit(Field{"slot", "", Axis::kCutEdge, kRecorded}, &CutEdge::slot);
  visit(Field{"part", "", Axis::kCutEdge, kRecorded}, &CutEdge::part);
  visit(Field{"family", "", Axis::kCutEdge, kRecorded}, &CutEdge::family);
  visit(Field{"incision", "", Axis::kCutEdge, kRecorded}, &CutEdge::incision);
  visit(Field{"rightward", "", Axis::kCutEdge, kRecorded}, &CutEdge::rightward);
  visit(Field{"fraction", "", Axis::kCutEdge, kRecorded}, &CutEdge::fraction);
  visit(Field{"along", "m", Axis::kCutEdge, kRecorded}, &CutEdge::along);
}

template <class M, class Visit>
requires std::is_same_v<std::remove_const_t<M>, Model>
void visit_fields(M& m, const Visit& visit) {
  visit(Field{"inverse_mass", "1/kg", Axis::kSlot}, m.inverse_mass);
  visit(Field{"root_stiffness", "Pa^1/2", Axis::kSlot}, m.root_stiffness);
  visit(Field{"tissue", "", Axis::kSlot}, m.tissue);
  visit(Field{"hu", "HU", Axis::kSlot}, m.hu);
  visit(Field{"cell_young", "Pa", Axis::kSlot}, m.cell_young);
  visit(Field{"around", "", Axis::kSlot}, m.around);
  visit(Field{"moving", ""}, m.moving.all);
  visit(Field{"moving_begin", "", Axis::kRow}, m.moving.row_begin);
  visit(Field{"joining", ""}, m.joining.all);
  visit(Field{"joining_begin", "", Axis::kRow}, m.joining.row_begin);
  visit(Field{"skin_triangles", "", Axis::kSkinTriangle}, m.skin.triangles);
  visit(Field{"lines", "", Axis::kSkinTriangle}, m.skin.lines);
  visit(Field{"batch_begin", ""}, m.skin.batch_begin);
  visit(Field{"layer_begin", ""}, m.skin.layer_begin);
  visit(Field{"skin_nodes", ""}, m.skin.nodes);
  visit(Field{"skin_pull", "N"}, m.skin.pull);
  visit(Field{"corner_begin", ""}, m.skin.corner_begin);
  visit(Field{"corners", ""}, m.skin.corners);
  visit(Field{"row_begin", "", Axis::kRow}, m.skin.row_begin);
  visit(Field{"lanes_begin", "", Axis::kRow}, m.skin.lanes_begin);
  visit(Field{"batches", ""}, m.skin.batches);
}

}  // namespace turgor::lattice
