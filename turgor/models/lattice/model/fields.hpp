// Fields of the lattice model for its hash, its memory and recordings (core/field.hpp).
#pragma once

#include "turgor/core/field.hpp"
#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

template <class F, class Visit>
requires std::is_same_v<std::remove_const_t<F>, SymmetricField>
void visit_fields(F& f, const Visit& visit) {
  for (auto* entry : {&f.xx, &f.yy, &f.zz, &f.xy, &f.xz, &f.yz})
    visit(Field{"entry", "J", Axis::kSlot}, *entry);
}

/// `cut` determines skin_cut and row_cut. The cut edges of the fine lattice determine fragments and wounds.
template <class S, class Visit>
requires std::is_same_v<std::remove_const_t<S>, State>
void visit_fields(S& s, const Visit& visit) {
  visit(Field{"displacement", "m", Axis::kSlot, kHashed | kRecorded}, s.motion.u);
  visit(Field{"displacement_before", "m", Axis::kSlot}, s.motion.u_before);
  visit(Field{"velocity", "m/s", Axis::kSlot, kHashed}, s.motion.v);
  visit(Field{"cut", "", Axis::kSlot, kHashed | kRecorded}, s.cuts.cut);
  visit(Field{"removed", "", Axis::kSlot, kHashed | kRecorded}, s.cuts.removed);
  visit(Field{"row_cut", "", Axis::kRow, kRecorded}, s.cuts.row_cut);
  visit(Field{"skin_cut", "", Axis::kSkinTriangle, kRecorded}, s.cuts.skin_cut);
  visit(Field{"cut_edge", "", Axis::kCutEdge, kRecorded}, s.cuts.edges);
  visit(Field{"cut_fraction_samples", ""}, s.cuts.samples);
  visit(Field{"virtual_nodes", "m"}, s.motion.virtual_u);
  visit(Field{"virtual_nodes_before", "m"}, s.motion.virtual_u_before);
  visit(Field{"cut_cell_elements", ""}, s.cut_elements.cells);
  visit(Field{"cut_skin_elements", ""}, s.cut_elements.skin);
  visit(Field{"element_nodes", ""}, s.cut_elements.nodes);
  visit(Field{"element_virtual_nodes", ""}, s.cut_elements.virtual_nodes);
  visit(Field{"node_elements", ""}, s.cut_elements.references);
  visit(Field{"virtual_node_keys", ""}, s.cut_elements.virtual_node_keys);
  visit(Field{"still", "", Axis::kRow}, s.sleep.still_steps);
  visit(Field{"awake", "", Axis::kRow}, s.sleep.awake);
  visit(Field{"moved", "", Axis::kRow}, s.sleep.moved);
  visit(Field{"residual", "N"}, s.workspace.residual.layers);
  visit(Field{"viscous_history", "J"}, s.viscosity.history);
}

/// Columns of a list of cut edges.
template <class Visit>
void visit_columns(const CutEdge*, const Visit& visit) {
  visit(Field{"slot", "", Axis::kCutEdge, kRecorded}, &CutEdge::slot);
  visit(Field{"sub_index", "", Axis::kCutEdge, kRecorded}, &CutEdge::sub_index);
  visit(Field{"family", "", Axis::kCutEdge, kRecorded}, &CutEdge::family);
  visit(Field{"incision", "", Axis::kCutEdge, kRecorded}, &CutEdge::incision);
  visit(Field{"rightward", "", Axis::kCutEdge, kRecorded}, &CutEdge::rightward);
  visit(Field{"fraction", "", Axis::kCutEdge, kRecorded}, &CutEdge::fraction);
  visit(Field{"along", "m", Axis::kCutEdge, kRecorded}, &CutEdge::along);
}

template <class M, class Visit>
requires std::is_same_v<std::remove_const_t<M>, Model>
void visit_fields(M& m, const Visit& visit) {
  visit(Field{"inverse_mass", "1/kg", Axis::kSlot}, m.anatomy.inverse_mass);
  visit(Field{"root_stiffness", "Pa^1/2", Axis::kSlot}, m.springs.root_stiffness);
  visit(Field{"tissue", "", Axis::kSlot}, m.anatomy.tissue);
  visit(Field{"hu", "HU", Axis::kSlot}, m.anatomy.hu);
  visit(Field{"cell_young", "Pa", Axis::kSlot}, m.anatomy.cell_young);
  visit(Field{"cell_center", "", Axis::kSlot}, m.anatomy.cell_center);
  visit(Field{"cell_shear", "m^3", Axis::kSlot}, m.anatomy.cell_laws.shear);
  visit(Field{"cell_bulk", "m^3", Axis::kSlot}, m.anatomy.cell_laws.bulk);
  visit(Field{"cell_stiffening", "", Axis::kSlot}, m.anatomy.cell_laws.stiffening);
  visit(Field{"cell_fiber", "m^3", Axis::kSlot}, m.anatomy.cell_laws.fiber);
  visit(Field{"cell_fiber_stiffening", "", Axis::kSlot}, m.anatomy.cell_laws.fiber_stiffening);
  visit(Field{"cell_fiber_x", "", Axis::kSlot}, m.anatomy.cell_laws.fiber_x);
  visit(Field{"cell_fiber_y", "", Axis::kSlot}, m.anatomy.cell_laws.fiber_y);
  visit(Field{"cell_fiber_z", "", Axis::kSlot}, m.anatomy.cell_laws.fiber_z);
  visit(Field{"around", "", Axis::kSlot}, m.vbd.incident_elements);
  visit(Field{"moving", ""}, m.anatomy.free_runs.all);
  visit(Field{"moving_begin", "", Axis::kRow}, m.anatomy.free_runs.row_begin);
  visit(Field{"joining", ""}, m.pbd.constraint_runs.all);
  visit(Field{"joining_begin", "", Axis::kRow}, m.pbd.constraint_runs.row_begin);
  visit(Field{"skin_triangles", "", Axis::kSkinTriangle}, m.anatomy.skin.triangles);
  visit(Field{"lines", "", Axis::kSkinTriangle}, m.anatomy.skin.lines);
  visit(Field{"skin_patches", ""}, m.anatomy.skin.patches);
  visit(Field{"batch_begin", ""}, m.anatomy.skin.batch_begin);
  visit(Field{"layer_begin", ""}, m.anatomy.skin.layer_begin);
  visit(Field{"skin_nodes", ""}, m.anatomy.skin.nodes);
  visit(Field{"prestress_force", "N"}, m.prestress_force);
  visit(Field{"corner_begin", ""}, m.vbd.corner_begin);
  visit(Field{"corners", ""}, m.vbd.corners);
  visit(Field{"patch_corners", ""}, m.vbd.patch_corners);
  visit(Field{"row_begin", "", Axis::kRow}, m.anatomy.skin.row_begin);
  visit(Field{"lanes_begin", "", Axis::kRow}, m.vbd.lanes_begin);
  visit(Field{"batches", ""}, m.pbd.skin_batches);
}

}  // namespace turgor::lattice
