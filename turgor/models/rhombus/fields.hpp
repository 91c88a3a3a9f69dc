// Fields of the rhombus model for state hash and memory size (core/field.hpp).
#pragma once

#include "turgor/core/field.hpp"
#include "turgor/models/rhombus/rhombus.hpp"

namespace turgor::rhombus {

template <class S, class Visit>
requires std::is_same_v<std::remove_const_t<S>, State>
void visit_fields(S& s, const Visit& visit) {
  visit(Field{"displacement", "m", Axis::kVertex, kHashed}, s.displacement);
  visit(Field{"touches", ""}, s.touches);
  visit(Field{"moved", ""}, s.moved);
  visit(Field{"distances", "m"}, s.distances);
  visit(Field{"carried", "m", Axis::kVertex}, s.carried);
  visit(Field{"ring", "m", Axis::kVertex}, s.ring);
  visit(Field{"listed", "", Axis::kVertex}, s.listed);
}

template <class F, class Visit>
requires std::is_same_v<std::remove_const_t<F>, GeodesicField>
void visit_fields(F& f, const Visit& visit) {
  visit(Field{"distance", "m", Axis::kVertex}, f.distance);
  visit(Field{"reached", ""}, f.reached);
  visit(Field{"front", ""}, f.front);
}

template <class M, class Visit>
requires std::is_same_v<std::remove_const_t<M>, Model>
void visit_fields(M& m, const Visit& visit) {
  visit(Field{"vertices", "m", Axis::kVertex}, m.surface.vertices);
  visit(Field{"triangles", "", Axis::kTriangle}, m.surface.triangles);
  visit(Field{"across", "", Axis::kTriangle}, m.surface.across);
  visit(Field{"corner_begin", "", Axis::kVertex}, m.surface.corner_begin);
  visit(Field{"corners", "", Axis::kTriangle}, m.surface.corners);
  visit(Field{"normals", "", Axis::kVertex}, m.surface.normals);
  visit(Field{"tree_vertices", "m", Axis::kVertex}, m.tree.vertices);
  visit(Field{"tree_triangles", "", Axis::kTriangle}, m.tree.triangles);
  visit(Field{"tree_nodes", "m"}, m.tree.boxes.nodes);
  visit(Field{"tree_items", "", Axis::kTriangle}, m.tree.boxes.items);
  visit(Field{"area", "m²", Axis::kVertex}, m.area);
  visit(Field{"stiffness", "", Axis::kVertex}, m.stiffness);
  visit(Field{"stiffness_gradient", "1/m", Axis::kVertex}, m.stiffness_gradient);
}

}  // namespace turgor::rhombus
