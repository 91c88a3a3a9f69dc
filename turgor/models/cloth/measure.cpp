#include "turgor/models/cloth/measure.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/surface_check.hpp"
#include "turgor/models/cloth/contact/contact.hpp"
#include "turgor/models/cloth/contact/spatial_hash.hpp"
#include "turgor/models/cloth/forces/membrane.hpp"
#include "turgor/models/cloth/model/fields.hpp"
#include "turgor/models/cloth/solver/two_level.hpp"

namespace turgor::cloth {

namespace {

/// Calls visit(entry, other vertex) for the entries of a vertex in its rows.
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

/// Calls visit(weight, other vertex) for the bending couplings of a vertex.
template <class Visit>
void for_bending_of(const Model& model, std::size_t vertex, const Visit& visit) {
  for (const Rows* rows : {&model.rows, &model.far_rows})
    if (!rows->bend.empty())
      for_row(*rows, vertex, [&](std::size_t entry, std::size_t other) {
        if (rows->bend[entry] != 0) visit(double(rows->bend[entry]), other);
      });
}

/// Calls visit(triangle) for the triangles around a vertex.
template <class Visit>
void for_triangles_of(const Model& model, std::size_t vertex, const Visit& visit) {
  const ChunkTriangles& chunks = model.chunk_triangles;
  for (int n = chunks.begin[vertex / kChunk]; n < chunks.begin[vertex / kChunk + 1]; n++) {
    const auto t = std::size_t(chunks.triangle[std::size_t(n)]);
    const Int3 corner = model.triangles[t];
    if (corner.x == int(vertex) || corner.y == int(vertex) || corner.z == int(vertex)) visit(t);
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

/// Energy of membrane and bending [J]. A bending pair of weight w has ½ w |x_i − x_j|²; it is visited from
/// both ends, hence the quarter.
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

/// Force of membrane and bending on a vertex, without damping [N].
Vec3d sheet_force(const Model& model, const State& state, std::size_t v) {
  Vec3d force;
  // membrane: side tensions of incident triangles
  for_triangles_of(model, v, [&](std::size_t t) {
    const Int3 corner = model.triangles[t];
    const TriangleTension tension = triangle_tension(model, state, t);
    for (int side = 0; side < 3; side++) {
      const int i = corner[side], j = corner[(side + 1) % 3];
      if (i != int(v) && j != int(v)) continue;
      const int other = i == int(v) ? j : i;
      force += (Vec3d(state.x[std::size_t(other)]) - Vec3d(state.x[v])) * tension.side[std::size_t(side)];
    }
  });
  // bending
  for_bending_of(model, v, [&](double weight, std::size_t other) {
    force += (Vec3d(state.x[other]) - Vec3d(state.x[v])) * weight;
  });
  return force;
}

/// Force of the springs on a vertex [N]: k (L − L₀) n plus stretch damping β k [n nᵀ + max(0, 1 − L₀/L) (I −
/// n nᵀ)] u, with n the direction of the spring and u the relative velocity.
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
  TURGOR_CHECK(state.x.size() >= std::size_t(model.count), "positions are on the host");
  Energy sum;
  // elastic
  if (model.params.fabric.law == Law::kSheet)
    sum.elastic = sheet_energy(model, state);
  else
    for_each_half_spring(model, state, [&](double k, double rest, double length) {
      sum.elastic += k * (length - rest) * (length - rest) / 4;
    });
  // kinetic and potential
  for (int i = 0; i < model.count; i++) {
    const auto v = std::size_t(i);
    const Vec3d x(state.x[v]), velocity(state.v[v]);
    sum.kinetic += double(model.mass[v]) * dot(velocity, velocity) / 2;
    sum.potential -= double(model.mass[v]) * dot(gravity, x);
  }
  return sum;
}

Vec3d momentum(const Model& model, const State& state) {
  TURGOR_CHECK(state.v.size() >= std::size_t(model.count), "velocities are on the host");
  Vec3d sum;
  for (std::size_t v = 0; v < std::size_t(model.count); v++) sum += Vec3d(state.v[v]) * double(model.mass[v]);
  return sum;
}

Vec3d hold_force(const Model& model, const State& state, int mesh_vertex, Vec3d gravity, Vec3d change,
                 double dt) {
  TURGOR_CHECK(is_index(mesh_vertex, model.model_vertex.size()), "a held vertex is of the mesh");
  TURGOR_CHECK(is_step_length(dt), "a step has a positive length");
  // inertia, weight and damping of motion
  const auto v = std::size_t(model.model_vertex[std::size_t(mesh_vertex)]);
  const Vec3d velocity(state.v[v]);
  const double mass = double(model.mass[v]);
  Vec3d force = (change / dt - gravity + velocity * model.params.damping.motion) * mass;
  // elastic forces
  force -=
      model.params.fabric.law == Law::kSheet ? sheet_force(model, state, v) : spring_force(model, state, v);
  // contact impulses of the step
  if (!state.contacts.touches(int(v))) return force;
  for (int n = state.contacts.begin[v]; n < state.contacts.begin[v + 1]; n++) {
    const auto item = std::size_t(state.contacts.item[std::size_t(n)]);
    const Contact& c = state.contacts.list[item / 4];
    force -=
        Vec3d(c.normal * c.impulse + c.friction_impulse) * (double(c.weight[item % 4]) / state.impulse_time);
  }
  return force;
}

std::vector<int> vertices_of_hold_forces(const Model& model, std::span<const int> mesh_vertices) {
  std::vector<int> read;
  for (const int mesh_vertex : mesh_vertices) {
    const int vertex = model.model_vertex[std::size_t(mesh_vertex)];
    const auto v = std::size_t(vertex);
    read.push_back(vertex);
    for_springs_of(model, v, [&](double, double, std::size_t other) { read.push_back(int(other)); });
    for_bending_of(model, v, [&](double, std::size_t other) { read.push_back(int(other)); });
    if (model.params.fabric.law != Law::kSheet) continue;
    for_triangles_of(model, v, [&](std::size_t t) {
      for (int k = 0; k < 3; k++) read.push_back(model.triangles[t][k]);
    });
  }
  sort_unique(read);
  return read;
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
  // pairs of near vertices in the exclusion list
  SpatialHash near;
  sort_points(exec, state.x, model.count, Real(4.1 * thickness), near);
  for (int i = 0; i < model.count; i++)
    visit_near(near, state.x[std::size_t(i)], Real(2 * thickness), [&](int j, Vec3 xj) {
      const auto& [begin, item] = model.excluded;
      const auto from = item.begin() + begin[std::size_t(i)], to = item.begin() + begin[std::size_t(i) + 1];
      if (j <= i || std::find(from, to, j) != to) return;
      const double distance = norm(Vec3d(state.x[std::size_t(i)]) - Vec3d(xj));
      result.smallest = std::min(result.smallest, distance);
      result.too_near += distance < 0.99 * thickness;
    });
  // intersecting triangles
  result.crossings = int(crossing_triangles(exec, model_surface(model, state)).size());
  return result;
}

TriMesh model_surface(const Model& model, const State& state) {
  TURGOR_CHECK(state.x.size() >= std::size_t(model.count), "positions are on the host");
  TriMesh mesh{.triangles = model.triangles};
  for (int v = 0; v < model.count; v++) mesh.vertices.push_back(state.x[std::size_t(v)]);
  return mesh;
}

TriMesh surface(const Model& model, const State& state, std::vector<Int3> mesh_triangles) {
  const std::vector<Vec3> normals =
      vertex_normals(model_surface(model, state));  // smooth across welded seams
  TriMesh mesh{.triangles = std::move(mesh_triangles)};
  for (const int v : model.model_vertex) {
    mesh.vertices.push_back(state.x[std::size_t(v)]);
    mesh.normals.push_back(normals[std::size_t(v)]);
  }
  return mesh;
}

std::vector<Vec3> displacements(const Model& model, const State& state) {
  TURGOR_CHECK(state.x.size() >= std::size_t(model.count), "positions are on the host");
  std::vector<Vec3> moved;
  for (const int v : model.model_vertex)
    moved.push_back(state.x[std::size_t(v)] - model.x_rest[std::size_t(v)]);
  return moved;
}

std::uint64_t state_hash(const Model& model, const State& state) {
  return hash_of_fields(state, 0, std::size_t(model.count), kHashSeed);
}

std::size_t memory_bytes(const Model& model, const State& state) {
  return bytes_of_fields(model, state) + coarse_system_bytes(state.system.two_level);
}

}  // namespace turgor::cloth
