#include "turgor/models/cloth/measure.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/geometry/surface_check.hpp"
#include "turgor/models/cloth/fields.hpp"

namespace turgor::cloth {

namespace {

/// Calls visit(stiffness, rest, other vertex) for the springs of a vertex.
template <class Visit>
void for_springs_of(const Model& model, std::size_t vertex, const Visit& visit) {
  const Rows& rows = model.rows;
  const std::size_t batch = vertex / std::size_t(kLanes), l = vertex % std::size_t(kLanes);
  for (int s = rows.slot_begin[batch]; s < rows.slot_begin[batch + 1]; s++) {
    const std::size_t entry = std::size_t(s) * std::size_t(kLanes) + l;
    const int first = rows.first[std::size_t(s)];
    const int other = first >= 0 ? first + int(l) : rows.gathered[std::size_t(-1 - first) + l];
    if (rows.stiffness[entry] > 0)
      visit(double(rows.stiffness[entry]), double(rows.rest[entry]), std::size_t(other));
  }
}

/// Calls visit(stiffness, rest, length) for both halves of every spring.
template <class Visit>
void for_each_half_spring(const Model& model, const State& state, const Visit& visit) {
  for (std::size_t v = 0; v < std::size_t(model.count); v++)
    for_springs_of(model, v, [&](double k, double rest, std::size_t other) {
      visit(k, rest, norm(Vec3d(state.x[other]) - Vec3d(state.x[v])));
    });
}

}  // namespace

Energy energy(const Model& model, const State& state, Vec3d gravity) {
  Energy sum;
  for_each_half_spring(model, state, [&](double k, double rest, double length) {
    sum.elastic += k * (length - rest) * (length - rest) / 4;
  });
  for (int i = 0; i < model.count; i++) {
    const auto v = std::size_t(i);
    const Vec3d x(state.x[v]), velocity(state.v[v]);
    sum.kinetic += double(model.mass[v]) * dot(velocity, velocity) / 2;
    sum.potential -= double(model.mass[v]) * dot(gravity, x);
  }
  return sum;
}

Vec3d momentum(const Model& model, const State& state) {
  Vec3d sum;
  for (std::size_t v = 0; v < std::size_t(model.count); v++) sum += Vec3d(state.v[v]) * double(model.mass[v]);
  return sum;
}

Vec3d hold_force(const Model& model, const State& state, int mesh_vertex, Vec3d gravity, Vec3d change,
                 double dt) {
  const auto v = std::size_t(model.place[std::size_t(mesh_vertex)]);
  const Vec3d x(state.x[v]), velocity(state.v[v]);
  const double mass = double(model.mass[v]), damping = model.params.damping.stretch;
  Vec3d force = (change / dt - gravity + velocity * model.params.damping.motion) * mass;
  for_springs_of(model, v, [&](double k, double rest, std::size_t other) {
    const Vec3d e = Vec3d(state.x[other]) - x, u = Vec3d(state.v[other]) - velocity, n = normalized(e);
    const double stretch = 1 - rest / norm(e), across = std::max(stretch, 0.0);
    force -= (e * stretch + (n * (dot(n, u) * (1 - across)) + u * across) * damping) * k;
  });
  if (!state.contacts.touches(int(v))) return force;
  for (int n = state.contacts.begin[v]; n < state.contacts.begin[v + 1]; n++) {
    const auto item = std::size_t(state.contacts.item[std::size_t(n)]);
    const Contact& c = state.contacts.list[item / 4];
    force -= Vec3d(c.normal * c.impulse + c.rub) * (double(c.weight[item % 4]) / dt);
  }
  return force;
}

double largest_stretch(const Model& model, const State& state) {
  double largest = 0;
  for_each_half_spring(
      model, state, [&](double, double rest, double length) { largest = std::max(largest, length / rest); });
  return largest;
}

SelfDistance self_distance(const Exec& exec, const Model& model, const State& state) {
  SelfDistance result;
  if (!model.params.collision.self) return result;
  const double thickness = model.params.collision.thickness;
  NearPoints near;
  sort_points(exec, state.x, model.count, Real(4.1 * thickness), near);
  for (int i = 0; i < model.count; i++)
    visit_near(near, state.x[std::size_t(i)], Real(2 * thickness), [&](int j, Vec3 xj) {
      const auto& [begin, item] = model.near;
      const auto from = item.begin() + begin[std::size_t(i)], to = item.begin() + begin[std::size_t(i) + 1];
      if (j <= i || std::find(from, to, j) != to) return;
      const double distance = norm(Vec3d(state.x[std::size_t(i)]) - Vec3d(xj));
      result.smallest = std::min(result.smallest, distance);
      result.too_near += distance < 0.99 * thickness;
    });
  result.crossings = int(crossing_triangles(exec, model_surface(model, state)).size());
  return result;
}

std::size_t memory_bytes(const Model& model, const State& state) { return bytes_of_fields(model, state); }

}  // namespace turgor::cloth
