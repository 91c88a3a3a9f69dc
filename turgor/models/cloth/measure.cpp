#include "turgor/models/cloth/measure.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/geometry/surface_check.hpp"

namespace turgor::cloth {

namespace {

/// Calls visit(stiffness, rest, length) for both halves of every spring.
template <class Visit>
void for_each_half_spring(const Model& model, const State& state, const Visit& visit) {
  const Rows& rows = model.rows;
  for (std::size_t batch = 0; batch < batch_count(rows); batch++)
    for (int s = rows.slot_begin[batch]; s < rows.slot_begin[batch + 1]; s++)
      for (int l = 0; l < kLanes; l++) {
        const auto entry = std::size_t(s * kLanes + l);
        const int first = rows.first[std::size_t(s)];
        const int other = first >= 0 ? first + l : rows.gathered[std::size_t(-1 - first + l)];
        if (!(rows.stiffness[entry] > 0)) continue;
        const Vec3d d =
            Vec3d(state.x[std::size_t(other)]) - Vec3d(state.x[batch * std::size_t(kLanes) + std::size_t(l)]);
        visit(double(rows.stiffness[entry]), double(rows.rest[entry]), norm(d));
      }
}

template <class T>
std::size_t bytes(const std::vector<T>& list) {
  return list.capacity() * sizeof(T);
}
template <class T>
std::size_t bytes(const aligned_vector<T>& list) {
  return list.capacity() * sizeof(T);
}
std::size_t bytes(const Vectors& a) { return bytes(a.x) + bytes(a.y) + bytes(a.z); }
std::size_t bytes(const NearPoints& near) {
  return bytes(near.begin) + bytes(near.bucket) + bytes(near.index) + bytes(near.x) + bytes(near.y) +
         bytes(near.z);
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
  result.crossings = int(crossing_triangles(exec, surface(model, state)).size());
  return result;
}

std::size_t memory_bytes(const Model& model, const State& state) {
  const Rows& rows = model.rows;
  const System& system = state.system;
  const Contacts& contacts = state.contacts;
  std::size_t sum = bytes(model.original) + bytes(model.place) + bytes(model.mass) + bytes(model.triangles) +
                    bytes(model.chunk_triangles.begin) + bytes(model.chunk_triangles.triangle) +
                    bytes(model.near.begin) + bytes(model.near.item) + bytes(model.coarse.triangles) +
                    bytes(model.coarse.edges) + bytes(model.x_rest);
  sum += bytes(rows.slot_begin) + bytes(rows.first) + bytes(rows.gathered) + bytes(rows.rest) +
         bytes(rows.stiffness);
  sum += bytes(system.along) + bytes(system.across) + bytes(state.free_mass) + bytes(state.near_points);
  for (const Vectors* field : {&state.x, &state.v, &system.force, &system.inverse[0], &system.inverse[1],
                               &system.change, &system.before, &system.air[0], &system.air[1], &system.search,
                               &system.image, &system.left, &contacts.middles})
    sum += bytes(*field);
  sum += bytes(contacts.list) + bytes(contacts.begin) + bytes(contacts.item) + bytes(contacts.touched) +
         bytes(contacts.midpoints);
  for (const auto& found : contacts.found) sum += bytes(found);
  return sum;
}

}  // namespace turgor::cloth
