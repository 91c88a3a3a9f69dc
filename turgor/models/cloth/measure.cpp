#include "turgor/models/cloth/measure.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/geometry/surface_check.hpp"
#include "turgor/models/cloth/model/fields.hpp"

namespace turgor::cloth {

namespace {

/// Calls visit(entry, other vertex) for the entries of a vertex' row.
template <class Visit>
void for_row(const Rows& rows, std::size_t vertex, const Visit& visit) {
  if (rows.slot_begin.empty()) return;
  const std::size_t batch = vertex / std::size_t(kLanes), l = vertex % std::size_t(kLanes);
  for (int s = rows.slot_begin[batch]; s < rows.slot_begin[batch + 1]; s++)
    visit(std::size_t(s) * std::size_t(kLanes) + l, std::size_t(neighbor(rows, s, int(l))));
}

/// Calls visit(stiffness, rest, other vertex) for the springs of a vertex, or the edges of a sheet.
template <class Visit>
void for_springs_of(const Model& model, std::size_t vertex, const Visit& visit) {
  const Rows& rows = model.rows;
  for_row(rows, vertex, [&](std::size_t entry, std::size_t other) {
    if (!(rows.stiffness[entry] > 0)) return;
    const double rest = rows.rest.empty() ? norm(Vec3d(model.x_rest[other]) - Vec3d(model.x_rest[vertex]))
                                          : double(rows.rest[entry]);
    visit(double(rows.stiffness[entry]), rest, other);
  });
}

/// Calls visit(weight, other vertex) for what a vertex is coupled with by bending.
template <class Visit>
void for_bending_of(const Model& model, std::size_t vertex, const Visit& visit) {
  for (const Rows* rows : {&model.rows, &model.far_rows})
    if (!rows->bend.empty())
      for_row(*rows, vertex, [&](std::size_t entry, std::size_t other) {
        if (rows->bend[entry] != 0) visit(double(rows->bend[entry]), other);
      });
}

/// Calls visit(stiffness, rest, length) for both halves of every spring.
template <class Visit>
void for_each_half_spring(const Model& model, const State& state, const Visit& visit) {
  for (std::size_t v = 0; v < std::size_t(model.count); v++)
    for_springs_of(model, v, [&](double k, double rest, std::size_t other) {
      visit(k, rest, norm(Vec3d(state.x[other]) - Vec3d(state.x[v])));
    });
}

/// Of the membrane and of bending [J].
double sheet_energy(const Model& model, const State& state) {
  double sum = 0;
  for (std::size_t t = 0; t < model.triangles.size(); t++) sum += triangle_tension(model, state, t).energy;
  for (std::size_t v = 0; v < std::size_t(model.count); v++)
    for_bending_of(model, v, [&](double weight, std::size_t other) {
      const Vec3d d = Vec3d(state.x[other]) - Vec3d(state.x[v]);
      sum += weight * dot(d, d) / 4;
    });
  return sum;
}

/// What the membrane and bending do to a vertex, without damping [N].
Vec3d sheet_force(const Model& model, const State& state, std::size_t v) {
  Vec3d force;
  const ChunkTriangles& chunks = model.chunk_triangles;
  for (int n = chunks.begin[v / kChunk]; n < chunks.begin[v / kChunk + 1]; n++) {
    const auto t = std::size_t(chunks.triangle[std::size_t(n)]);
    const Int3 corner = model.triangles[t];
    if (corner.x != int(v) && corner.y != int(v) && corner.z != int(v)) continue;
    const TriangleTension tension = triangle_tension(model, state, t);
    for (int side = 0; side < 3; side++) {
      const int i = corner[side], j = corner[(side + 1) % 3];
      if (i != int(v) && j != int(v)) continue;
      const int other = i == int(v) ? j : i;
      force += (Vec3d(state.x[std::size_t(other)]) - Vec3d(state.x[v])) * tension.side[std::size_t(side)];
    }
  }
  for_bending_of(model, v, [&](double weight, std::size_t other) {
    force += (Vec3d(state.x[other]) - Vec3d(state.x[v])) * weight;
  });
  return force;
}

/// What the springs do to a vertex, damping included [N].
Vec3d spring_force(const Model& model, const State& state, std::size_t v) {
  Vec3d force;
  for_springs_of(model, v, [&](double k, double rest, std::size_t other) {
    const Vec3d e = Vec3d(state.x[other]) - Vec3d(state.x[v]), u = Vec3d(state.v[other]) - Vec3d(state.v[v]);
    const Vec3d n = normalized(e);
    const double stretch = 1 - rest / norm(e), across = std::max(stretch, 0.0);
    force += (e * stretch + (n * (dot(n, u) * (1 - across)) + u * across) * model.params.damping.stretch) * k;
  });
  return force;
}

}  // namespace

Energy energy(const Model& model, const State& state, Vec3d gravity) {
  Energy sum;
  if (model.params.fabric.law == Law::kSheet)
    sum.elastic = sheet_energy(model, state);
  else
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
  const Vec3d velocity(state.v[v]);
  const double mass = double(model.mass[v]);
  Vec3d force = (change / dt - gravity + velocity * model.params.damping.motion) * mass;
  force -=
      model.params.fabric.law == Law::kSheet ? sheet_force(model, state, v) : spring_force(model, state, v);
  if (!state.contacts.touches(int(v))) return force;
  for (int n = state.contacts.begin[v]; n < state.contacts.begin[v + 1]; n++) {
    const auto item = std::size_t(state.contacts.item[std::size_t(n)]);
    const Contact& c = state.contacts.list[item / 4];
    force -=
        Vec3d(c.normal * c.impulse + c.friction_impulse) * (double(c.weight[item % 4]) / state.impulse_time);
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
  SpatialHash near;
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

std::size_t memory_bytes(const Model& model, const State& state) {
  return bytes_of_fields(model, state) + state.system.blocks.bytes();
}

}  // namespace turgor::cloth
