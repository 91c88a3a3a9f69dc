// Fields of the cloth model, for its hash, its memory size and recordings (core/field.hpp).
#pragma once

#include "turgor/core/field.hpp"
#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

template <class S, class Visit>
requires std::is_same_v<std::remove_const_t<S>, State>
void visit_fields(S& s, const Visit& visit) {
  visit(Field{"positions", "m", Axis::kVertex, kHashed | kRecorded}, s.x);
  visit(Field{"velocity", "m/s", Axis::kVertex, kHashed}, s.v);
  visit(Field{"free_mass", "kg", Axis::kVertex}, s.free_mass);
  visit(Field{"last_positions", "m", Axis::kVertex}, s.history.x);
  visit(Field{"last_velocity", "m/s", Axis::kVertex}, s.history.v);
  visit(Field{"along", "kg"}, s.system.along);
  visit(Field{"across", "kg"}, s.system.across);
  visit(Field{"force", "N s", Axis::kVertex}, s.system.force);
  visit(Field{"inverse_diagonal", "1/kg", Axis::kVertex}, s.system.inverse[0]);
  visit(Field{"inverse_off", "1/kg", Axis::kVertex}, s.system.inverse[1]);
  visit(Field{"change", "m/s", Axis::kVertex}, s.system.change);
  visit(Field{"before", "m/s", Axis::kVertex}, s.system.previous);
  visit(Field{"air_diagonal", "kg", Axis::kVertex}, s.system.air[0]);
  visit(Field{"air_off", "kg", Axis::kVertex}, s.system.air[1]);
  visit(Field{"search", "m/s", Axis::kVertex}, s.system.search);
  visit(Field{"image", "N s", Axis::kVertex}, s.system.image);
  visit(Field{"residual", "N s", Axis::kVertex}, s.system.residual_vector);
  visit(Field{"contacts", ""}, s.contacts.list);
  visit(Field{"contact_begin", "", Axis::kVertex}, s.contacts.begin);
  visit(Field{"contact_item", ""}, s.contacts.item);
  visit(Field{"contact_touched", ""}, s.contacts.touched);
  visit(Field{"contact_found", ""}, s.contacts.candidates);
  visit(Field{"contact_near_pairs", ""}, s.contacts.near_pairs);
  visit(Field{"implicit_contacts", ""}, s.implicit_contacts.contacts.list);
  visit(Field{"implicit_contact_begin", "", Axis::kVertex}, s.implicit_contacts.contacts.begin);
  visit(Field{"implicit_contact_item", ""}, s.implicit_contacts.contacts.item);
  visit(Field{"implicit_contact_touched", ""}, s.implicit_contacts.contacts.touched);
  visit(Field{"implicit_contact_found", ""}, s.implicit_contacts.contacts.candidates);
  visit(Field{"implicit_contact_answer", ""}, s.implicit_contacts.terms);
  visit(Field{"implicit_contact_inverse", "1/kg"}, s.implicit_contacts.inverse);
  visit(Field{"middles", "m"}, s.contacts.midpoints);
  visit(Field{"midpoints", "m"}, s.contacts.midpoint_hash);
  visit(Field{"spatial_hash", "m"}, s.spatial_hash);
  visit(Field{"motion_boxes", "m"}, s.ccd.boxes);
  visit(Field{"ccd_found", ""}, s.ccd.chunk_pairs);
  visit(Field{"ccd_pairs", ""}, s.ccd.ccd_pairs);
  visit(Field{"ccd_hits", ""}, s.ccd.recent_pairs);
  visit(Field{"in_impact_zone", ""}, s.ccd.in_impact_zone);
  visit(Field{"zone", ""}, s.ccd.zone);
}

template <class M, class Visit>
requires std::is_same_v<std::remove_const_t<M>, Model>
void visit_fields(M& m, const Visit& visit) {
  visit(Field{"original", "", Axis::kVertex}, m.original);
  visit(Field{"permutation", "", Axis::kVertex}, m.model_vertex);
  visit(Field{"mass", "kg", Axis::kVertex}, m.mass);
  visit(Field{"triangles", "", Axis::kTriangle}, m.triangles);
  visit(Field{"triangle_begin", "", Axis::kVertex}, m.triangle_begin);
  visit(Field{"chunk_begin", ""}, m.chunk_triangles.begin);
  visit(Field{"chunk_triangle", ""}, m.chunk_triangles.triangle);
  visit(Field{"near_begin", "", Axis::kVertex}, m.excluded.begin);
  visit(Field{"near_item", ""}, m.excluded.item);
  visit(Field{"block", "", Axis::kVertex}, m.blocks.of);
  visit(Field{"block_begin", ""}, m.blocks.begin);
  visit(Field{"block_vertex", ""}, m.blocks.vertex);
  visit(Field{"block_pair", ""}, m.blocks.pair);
  visit(Field{"coarse_triangles", ""}, m.large.triangles);
  visit(Field{"coarse_edges", ""}, m.large.edges);
  visit(Field{"across", ""}, m.large.across);
  visit(Field{"facing", ""}, m.large.facing);
  visit(Field{"star_begin", ""}, m.large.stars.begin);
  visit(Field{"star_item", ""}, m.large.stars.item);
  visit(Field{"x_rest", "m", Axis::kVertex}, m.x_rest);
  visit(Field{"slot_begin", ""}, m.rows.slot_begin);
  visit(Field{"first", ""}, m.rows.first);
  visit(Field{"gathered", ""}, m.rows.gathered);
  visit(Field{"rest_length", "m"}, m.rows.rest);
  visit(Field{"stiffness", "N/m"}, m.rows.stiffness);
  visit(Field{"bend", "N/m"}, m.rows.bend);
  visit(Field{"far_slot_begin", ""}, m.far_rows.slot_begin);
  visit(Field{"far_first", ""}, m.far_rows.first);
  visit(Field{"far_gathered", ""}, m.far_rows.gathered);
  visit(Field{"far_bend", "N/m"}, m.far_rows.bend);
  visit(Field{"spare", "N/m", Axis::kVertex}, m.extra_diagonal);
  visit(Field{"second_slope_warp", "1/m"}, m.membrane.second[0]);
  visit(Field{"second_slope_weft", "1/m"}, m.membrane.second[1]);
  visit(Field{"third_slope_warp", "1/m"}, m.membrane.third[0]);
  visit(Field{"third_slope_weft", "1/m"}, m.membrane.third[1]);
  visit(Field{"side_slot", ""}, m.membrane.slot);
  visit(Field{"wide_side_slot", ""}, m.membrane.wide_slot);
}

template <class N, class Visit>
requires std::is_same_v<std::remove_const_t<N>, SpatialHash>
void visit_fields(N& n, const Visit& visit) {
  visit(Field{"begin", ""}, n.begin);
  visit(Field{"bucket", ""}, n.bucket);
  visit(Field{"index", ""}, n.index);
  visit(Field{"x", "m"}, n.x);
  visit(Field{"y", "m"}, n.y);
  visit(Field{"z", "m"}, n.z);
}

}  // namespace turgor::cloth
