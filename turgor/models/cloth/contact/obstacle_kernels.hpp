// Contacts of a cloth with obstacles: which of its vertices, and which places of its triangles, must be kept
// from which.
#pragma once

#include "turgor/models/cloth/device/sheet_view.hpp"
#include "turgor/models/cloth/model/cloth.hpp"

namespace turgor::cloth {

/// The cloth before a step moves it.
struct FacingView {
  ConstVectorsView x, v;
  const Real* free_mass;
  ContactsView old;
  const int* triangle_begin;  // Model::triangle_begin, and the triangles
  const Int3* triangles;
  Real dt;

  /// Whether a place of the cloth at x with the velocity v must be kept from an obstacle.
  TURGOR_HD bool must_keep(const SurfacePoint& at, Vec3 place, Vec3 velocity, Real margin,
                           const ObstacleView& obstacle, Contact& contact) const {
    const Contact* before = find_old(old, contact);
    const Real closing = -dt * dot(velocity - at.velocity, at.normal),
               room = at.distance - Real(obstacle.gap);
    // A vertex that does not approach by itself may be pushed there by its neighbours.
    if (room >= larger(closing, margin) && !(before && before->impulse > 0)) return false;
    contact.normal = at.normal, contact.room = room, contact.plane = dot(at.normal, place) - room;
    contact.drift = at.velocity, contact.friction = Real(obstacle.friction);
    if (before)
      contact.impulse = before->impulse * before->warm_start,
      contact.friction_impulse = before->friction_impulse * before->warm_start;
    return true;
  }

  /// Vertex i, which nothing holds, and obstacle o: false, or the contact.
  TURGOR_HD bool touch(int i, int o, const ObstacleView& obstacle, Contact& contact) const {
    const auto vertex = std::size_t(i);
    const Vec3 place = x[vertex], velocity = v[vertex];
    const Real margin = Real(obstacle.gap) + dt * (norm(velocity) + Real(obstacle.speed));
    SurfacePoint at;
    if (!obstacle.shape.nearest(place, 2 * margin, at)) return false;
    contact.vertex = {i, -1, -1, -1}, contact.weight = {1, 0, 0, 0}, contact.obstacle = o;
    return must_keep(at, place, velocity, margin, obstacle, contact);
  }

  TURGOR_HD bool is_held(Int3 t) const { return free_mass[t.x] + free_mass[t.y] + free_mass[t.z] == 0; }
  /// A triangle that is not held and an obstacle that could pass between its vertices.
  TURGOR_HD bool touch_between(Int3 t, int o, const ObstacleView& obstacle, Contact& contact) const {
    constexpr Real kCorner = Real(0.999);  // of the weight: the vertex has its own contact
    const auto a = std::size_t(t.x), b = std::size_t(t.y), c = std::size_t(t.z);
    const Real fast = larger(norm(v[a]), larger(norm(v[b]), norm(v[c])));
    const Real margin = Real(obstacle.gap) + dt * (fast + Real(obstacle.speed));
    std::array<Real, 3> w{};
    SurfacePoint at;
    if (!obstacle.shape.rigid.nearest_in(x[a], x[b], x[c], 2 * margin, w, at)) return false;
    if (larger(w[0], larger(w[1], w[2])) > kCorner) return false;
    contact.vertex = {t.x, t.y, t.z, -1}, contact.weight = {w[0], w[1], w[2], 0}, contact.obstacle = o;
    const Vec3 place = x[a] * w[0] + x[b] * w[1] + x[c] * w[2];
    const Vec3 velocity = v[a] * w[0] + v[b] * w[1] + v[c] * w[2];
    return must_keep(at, place, velocity, margin, obstacle, contact);
  }

  /// Calls take(contact) for those of vertex i with each of the obstacles; obstacle(o) is one of `count`.
  template <class ObstacleOf, class Take>
  TURGOR_HD void visit(int i, int count, const ObstacleOf& obstacle, const Take& take) const {
    if (free_mass[i] == 0) return;
    for (int o = 0; o < count; o++) {
      Contact contact;
      if (touch(i, o, obstacle(o), contact)) take(contact);
    }
  }
  /// And for those of the triangles whose smallest vertex is i.
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

/// Is anything so small that it could pass between vertices?
inline bool any_between(std::span<const Obstacle> obstacles) {
  return std::any_of(obstacles.begin(), obstacles.end(),
                     [](const Obstacle& o) { return o.shape.may_pass_between(); });
}

}  // namespace turgor::cloth
