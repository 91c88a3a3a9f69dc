// The fields of the sfem model, for its size in memory (core/field.hpp). What changes while a body is touched
// is contact::TouchState.
#pragma once

#include "turgor/core/field.hpp"
#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

template <class M, class Visit>
requires std::is_same_v<std::remove_const_t<M>, Model>
void visit_fields(M& m, const Visit& visit) {
  visit(Field{"vertices", "m", Axis::kVertex}, m.body.mesh.vertices);
  visit(Field{"elements", ""}, m.body.mesh.elements);
  visit(Field{"regions", ""}, m.body.mesh.regions);
  visit(Field{"material", ""}, m.body.material);
  visit(Field{"fixed", "", Axis::kVertex}, m.body.fixed);
  visit(Field{"surface_triangles", "", Axis::kTriangle}, m.surface.triangles);
  visit(Field{"surface_elements", "", Axis::kTriangle}, m.surface.element);
  visit(Field{"neighbors", ""}, m.neighbors);
  visit(Field{"free_node", "", Axis::kVertex}, m.free_node);
  visit(Field{"vertex", ""}, m.vertex);
  visit(Field{"stiffness_rows", ""}, m.stiffness.row_begin);
  visit(Field{"stiffness_columns", ""}, m.stiffness.column);
  visit(Field{"stiffness", "N/m"}, m.stiffness.value);
  visit(Field{"mass", "kg", Axis::kVertex}, m.mass);
  if (m.factor) visit(Field{"factor", "(N/m)^1/2"}, m.factor->values);
  visit(Field{"kept_nodes", ""}, m.green.nodes);
  visit(Field{"slot", "", Axis::kVertex}, m.green.slot);
  visit(Field{"green_single", "m/N"}, m.green.single_values);
  visit(Field{"green_double", "m/N"}, m.green.double_values);
  visit(Field{"green_columns", "m/N"}, m.green.columns);
  visit(Field{"check_columns", "m/N"}, m.green.check.values);
}

}  // namespace turgor::sfem
