// Kernels for contacts of vertices and triangles with obstacles.
#pragma once

#include "turgor/models/cloth/contact/contact.hpp"
#include "turgor/models/cloth/model/sheet_view.hpp"
#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

/// Cloth at the beginning of a step.
struct FacingView {
  ConstVectorsView x, v;
  const Real* free_mass;
  ContactsView old;
  const int* triangle_begin;  // of Model
  const Int3* triangles;
  Real dt;

  /// Tests a cloth point with the given velocity against an obstacle, and fills in the contact. False: it
  /// neither approaches nor touched before.
  TURGOR_HD bool make_contact(const SurfacePoint& at, Vec3 point, Vec3 velocity, Real margin,
                              const ObstacleView& obstacle, Contact& contact) const {
    const Contact* before = find_previous(old, contact);
    const Real closing = -dt * dot(velocity - at.velocity, at.normal), gap = at.distance - Real(obstacle.gap);
    // A vertex that does not approach by itself may be pushed by its neighbors, hence the margin.
    if (gap >= larger(closing, margin) && !(before && before->impulse > 0)) return false;
    contact.normal = at.normal, contact.gap = gap, contact.plane = dot(at.normal, point) - gap;
    contact.obstacle_velocity = at.velocity, contact.friction = Real(obstacle.friction);
    if (before)
      contact.impulse = before->impulse * before->warm_start,
      contact.friction_impulse = before->friction_impulse * before->warm_start;
    return true;
  }

  /// Tests the free vertex i against obstacle o. False: no contact.
  TURGOR_HD bool touch(int i, int o, const ObstacleView& obstacle, Contact& contact) const {
    const auto vertex = std::size_t(i);
    const Vec3 point = x[vertex], velocity = v[vertex];
    const Real margin = Real(obstacle.gap) + dt * (norm(velocity) + Real(obstacle.speed));
    SurfacePoint at;
    if (!obstacle.shape.nearest(point, 2 * margin, at)) return false;
    contact.vertex = {i, -1, -1, -1}, contact.weight = {1, 0, 0, 0}, contact.obstacle = o;
    return make_contact(at, point, velocity, margin, obstacle, contact);
  }

  TURGOR_HD bool is_held(Int3 t) const { return free_mass[t.x] + free_mass[t.y] + free_mass[t.z] == 0; }
  /// Tests a triangle against an obstacle that is small enough to pass between its vertices.
  TURGOR_HD bool touch_between(Int3 t, int o, const ObstacleView& obstacle, Contact& contact) const {
    constexpr Real kCorner = Real(0.999);  // weight above which the vertex has the contact
    // search distance
    const auto a = std::size_t(t.x), b = std::size_t(t.y), c = std::size_t(t.z);
    const Real fast = larger(norm(v[a]), larger(norm(v[b]), norm(v[c])));
    const Real margin = Real(obstacle.gap) + dt * (fast + Real(obstacle.speed));
    // nearest point inside the triangle
    std::array<Real, 3> w{};
    SurfacePoint at;
    if (!obstacle.shape.rigid.nearest_in(x[a], x[b], x[c], 2 * margin, w, at)) return false;
    if (larger(w[0], larger(w[1], w[2])) > kCorner) return false;
    // contact of that point
    contact.vertex = {t.x, t.y, t.z, -1}, contact.weight = {w[0], w[1], w[2], 0}, contact.obstacle = o;
    const Vec3 point = x[a] * w[0] + x[b] * w[1] + x[c] * w[2];
    const Vec3 velocity = v[a] * w[0] + v[b] * w[1] + v[c] * w[2];
    return make_contact(at, point, velocity, margin, obstacle, contact);
  }

  /// Calls take(contact) for the contacts of vertex i; obstacle(o) returns one of `count` obstacles.
  template <class ObstacleOf, class Take>
  TURGOR_HD void visit(int i, int count, const ObstacleOf& obstacle, const Take& take) const {
    if (free_mass[i] == 0) return;
    for (int o = 0; o < count; o++) {
      Contact contact;
      if (touch(i, o, obstacle(o), contact)) take(contact);
    }
  }
  /// The same for the triangles whose smallest vertex is i.
  template <class ObstacleOf, class Take>
  TURGOR_HD void visit_between(int i, int count, const ObstacleOf& obstacle, const Take& take) const {
    for (int n = triangle_begin[i]; n < triangle_begin[i + 1]; n++) {
      const Int3 t = triangles[n];
      if (is_held(t)) continue;
      for (int o = 0; o < count; o++) {
        Contact contact;
        if (obstacle(o).shape.may_pass_between() && touch_between(t, o, obstacle(o), contact)) take(contact);
      }
    }
  }
};
inline FacingView facing_view(const Model& model, const State& state, double dt) {
  return {view(state.x),
          view(state.v),
          state.free_mass.data(),
          view(state.contacts),
          model.triangle_begin.data(),
          model.triangles.data(),
          Real(dt)};
}

/// True if any obstacle is small enough to pass between vertices.
inline bool any_between(std::span<const Obstacle> obstacles) {
  return std::any_of(obstacles.begin(), obstacles.end(),
                     [](const Obstacle& o) { return o.shape.may_pass_between(); });
}

}  // namespace turgor::cloth
