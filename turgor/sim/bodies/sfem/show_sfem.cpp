// Drawn surface of a body: the patch's surface inside the patch, the coarse one outside. A finer surface of
// the scene is embedded in the coarse elements, and inside the patch follows its displacement.
#include <algorithm>
#include <array>
#include <map>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/geometry/rounded.hpp"
#include "turgor/models/sfem/green.hpp"
#include "turgor/sim/bodies/sfem/load_sfem.hpp"
#include "turgor/sim/smooth_snapshot.hpp"

namespace turgor {

namespace {

std::vector<double> flat(std::span<const Vec3d> vectors) {
  std::vector<double> values;
  values.reserve(3 * vectors.size());
  for (const Vec3d v : vectors) values.insert(values.end(), {v.x, v.y, v.z});
  return values;
}

/// Mesh vertex of each patch point; -1 = between vertices.
std::vector<int> vertices_of_points(const SfemBody& body) {
  // vertices of the patch elements by rest position
  std::map<std::array<double, 3>, int> vertex_at;
  const std::vector<Vec3d>& x = body.model.body.mesh.vertices;
  for (const int e : body.now.patch->elements)
    for (const int v : element(body.model.body.mesh, std::size_t(e))) {
      const Vec3d p = x[std::size_t(v)];
      vertex_at[{p.x, p.y, p.z}] = v;
    }
  // look up the patch points
  std::vector<int> vertices;
  for (const sfem::PatchPoint& point : body.now.patch->points) {
    const auto found = vertex_at.find({point.x.x, point.x.y, point.x.z});
    vertices.push_back(found == vertex_at.end() ? -1 : found->second);
  }
  return vertices;
}

int add_vertex(Vec3d rest, int mesh_vertex, BodySnapshot& surface) {
  surface.rest.push_back(Vec3(rest));
  surface.mesh_vertex.push_back(mesh_vertex);
  return int(surface.rest.size()) - 1;
}

/// Adds the surface vertices of the mesh, ascending; returns their index for each mesh vertex, -1 = inside.
std::vector<int> add_mesh_vertices(const sfem::Model& model, BodySnapshot& surface) {
  const std::vector<Vec3d>& x = model.body.mesh.vertices;
  std::vector<int> index_of(x.size(), -1);
  for (const Int3 t : model.surface.triangles)
    for (const int v : {t.x, t.y, t.z}) index_of[std::size_t(v)] = 0;
  for (std::size_t v = 0; v < x.size(); v++)
    if (index_of[v] == 0) index_of[v] = add_vertex(x[v], int(v), surface);
  return index_of;
}

/// Coarse surface whose covered triangles are replaced by the patch. Vertices of the mesh come first and are
/// the same at all times; additional patch vertices follow.
void join_surface(const SfemBody& body, const std::vector<Vec3d>& coarse, const std::vector<float>& pressure,
                  BodySnapshot& surface) {
  const SolidMesh& mesh = body.model.body.mesh;
  TURGOR_CHECK(coarse.size() == mesh.vertices.size() && pressure.size() == body.now.patch->points.size(),
               "every vertex has a displacement, and every point a pressure");
  surface.rest.clear(), surface.displacement.clear(), surface.pressure.clear(), surface.triangles.clear();
  surface.mesh_vertex.clear();
  const std::vector<int> shown_vertex = add_mesh_vertices(body.model, surface);
  std::vector<int> shown_point(body.now.patch->points.size(), -1);
  for (const int v : surface.mesh_vertex) surface.displacement.push_back(Vec3(coarse[std::size_t(v)]));
  surface.pressure.resize(surface.rest.size());
  std::vector<bool> covered(mesh.vertices.size(), false), in_patch(element_count(mesh), false);
  for (const int e : body.now.patch->elements) in_patch[std::size_t(e)] = true;
  const std::vector<int> vertices = vertices_of_points(body);
  for (std::size_t p = 0; p < body.now.patch->points.size(); p++) {
    const Vec3d rest = body.now.patch->points[p].x;
    const int known = vertices[p] < 0 ? -1 : shown_vertex[std::size_t(vertices[p])];
    const auto n = std::size_t(shown_point[p] = known < 0 ? add_vertex(rest, -1, surface) : known);
    surface.displacement.resize(surface.rest.size()), surface.pressure.resize(surface.rest.size());
    surface.displacement[n] = Vec3(body.now.x[p] - rest), surface.pressure[n] = pressure[p];
    if (vertices[p] >= 0) covered[std::size_t(vertices[p])] = true;
  }
  for (const Int3 t : body.now.patch->triangles)
    surface.triangles.push_back(
        {shown_point[std::size_t(t.x)], shown_point[std::size_t(t.y)], shown_point[std::size_t(t.z)]});
  const SolidSurface& outer = body.model.surface;
  for (std::size_t i = 0; i < outer.triangles.size(); i++) {
    const Int3 t = outer.triangles[i];
    const bool is_covered = in_patch[std::size_t(outer.element[i])] && covered[std::size_t(t.x)] &&
                            covered[std::size_t(t.y)] && covered[std::size_t(t.z)];
    if (is_covered) continue;
    surface.triangles.push_back(
        {shown_vertex[std::size_t(t.x)], shown_vertex[std::size_t(t.y)], shown_vertex[std::size_t(t.z)]});
  }
}

/// Nearest point of the patch's surface with barycentric weights.
struct PatchLocation {
  Int3 point;
  Vec3d weight;
  double distance = 0;  // [m]
};
PatchLocation nearest_in_patch(const sfem::Patch& patch, Vec3d x) {
  PatchLocation best{.point = {}, .weight = {}, .distance = 1e300};
  for (const Int3 t : patch.triangles) {
    const Vec3d a = patch.points[std::size_t(t.x)].x, b = patch.points[std::size_t(t.y)].x,
                c = patch.points[std::size_t(t.z)].x;
    const Vec3d w = contact::closest_weights(x, a, b, c);
    const double distance = norm(a * w.x + b * w.y + c * w.z - x);
    if (distance < best.distance) best = {t, w, distance};
  }
  return best;
}

double longest_edge(const sfem::Patch& patch) {
  double longest = 0;
  for (const Int3 t : patch.triangles)
    for (int corner = 0; corner < 3; corner++)
      longest = std::max(longest, norm(patch.points[std::size_t(t[corner])].x -
                                       patch.points[std::size_t(t[(corner + 1) % 3])].x));
  return longest;
}

template <class Of>
auto interpolated(const PatchLocation& at, const Of& of) {
  return of(at.point.x) * at.weight.x + of(at.point.y) * at.weight.y + of(at.point.z) * at.weight.z;
}

/// Displacement of a point that the coarse functions do not represent [m].
Vec3d fine_displacement(const SfemBody& body, const std::vector<Vec3d>& coarse, int p) {
  const sfem::PatchPoint& point = body.now.patch->points[std::size_t(p)];
  Vec3d u = body.now.x[std::size_t(p)] - point.x;
  for (int s = 0; s < point.supports; s++) {
    const auto i = std::size_t(s);
    u -= coarse[std::size_t(body.now.patch->coarse[std::size_t(point.coarse[i])])] * point.weight[i];
  }
  return u;
}

/// Finer surface: interpolated in the coarse elements, plus the fine displacement near the patch.
void carry_surface(const Exec& exec, const SfemBody& body, const std::vector<Vec3d>& coarse,
                   const std::vector<float>& pressure, BodySnapshot& surface) {
  TURGOR_CHECK(coarse.size() == body.model.body.mesh.vertices.size() &&
                   pressure.size() == body.now.patch->points.size(),
               "every vertex has a displacement, and every point a pressure");
  const Embedding& embedding = body.seen->embedding;
  const std::size_t count = embedding.rest.size();
  surface.rest = embedding.rest;
  surface.triangles = body.seen->triangles;
  surface.mesh_vertex.clear();  // vertex numbers are those of its file
  std::vector<Vec3> moved(count);
  move(embedding, coarse, moved);
  surface.displacement.resize(count);
  surface.pressure.assign(count, 0);
  // the surfaces differ by less than the coarse triangle size; farther points are on another side
  const double reach = longest_edge(*body.now.patch);
  std::vector<std::uint8_t> near_patch(body.model.body.mesh.vertices.size(), 0);
  for (const int v : body.now.patch->coarse) near_patch[std::size_t(v)] = 1;
  parallel_for(exec, count, [&](std::size_t v) {
    Vec3d u = Vec3d(moved[v]) - Vec3d(embedding.rest[v]);
    const int* corners = &embedding.nodes[v * std::size_t(embedding.corners)];
    if (std::any_of(corners, corners + embedding.corners,
                    [&](int node) { return near_patch[std::size_t(node)] != 0; })) {
      const PatchLocation nearest = nearest_in_patch(*body.now.patch, Vec3d(embedding.rest[v]));
      if (nearest.distance < reach) {
        u += interpolated(nearest, [&](int p) { return fine_displacement(body, coarse, p); });
        surface.pressure[v] =
            float(interpolated(nearest, [&](int p) { return double(pressure[std::size_t(p)]); }));
      }
    }
    surface.displacement[v] = Vec3(u);
  });
}

/// Triangles of the mesh, over which pictures draw a smooth surface; a finer surface of the scene has none.
void show_coarse(const SfemBody& body, BodySnapshot& out) {
  if (body.seen) return;
  // triangles of the mesh by vertices of the snapshot
  std::vector<int> index_of(body.model.body.mesh.vertices.size(), -1);
  for (std::size_t v = 0; v < out.mesh_vertex.size(); v++)
    if (const int known = out.mesh_vertex[v]; is_index(known, index_of.size()))
      index_of[std::size_t(known)] = int(v);
  std::vector<Int3> coarse;
  for (const Int3 t : body.model.surface.triangles)
    coarse.push_back({index_of[std::size_t(t.x)], index_of[std::size_t(t.y)], index_of[std::size_t(t.z)]});
  set_coarse(coarse, out);
}

/// Contact pressure at every point of the patch [Pa].
void find_pressure(const SfemBody& body, std::vector<double>& pressure) {
  TURGOR_CHECK(pressure.size() == body.now.force.size(), "every point has a pressure");
  contact::PatchSurface surface;
  contact::measure_surface(*body.now.patch, surface);
  contact::contact_pressure(surface, body.now.force, pressure);
  for (double& one : pressure) one *= body.now.stiffness_scale;
}

/// Present positions.
void show_patch(const SfemBody& body, TriMesh& patch) {
  patch.triangles = body.now.patch->triangles;
  patch.vertices.clear();
  for (const Vec3d x : body.now.x) patch.vertices.emplace_back(x);
}

/// Present positions of inclusions. Vertices below the kept Green's functions do not move. Regions of few
/// elements are drawn smoothed.
void show_inside(const SfemBody& body, const std::vector<Vec3d>& coarse, TriMesh& inside) {
  constexpr std::size_t kFew = 200;  // triangles
  inside.vertices.clear(), inside.triangles.clear();
  for (const InnerRegion& region : body.inside) {
    TriMesh now;
    now.triangles = region.triangles;
    for (const int v : region.vertices)
      now.vertices.emplace_back(body.model.body.mesh.vertices[std::size_t(v)] + coarse[std::size_t(v)]);
    if (now.triangles.size() <= kFew) now = rounded(now);
    const int first = int(inside.vertices.size());
    inside.vertices.insert(inside.vertices.end(), now.vertices.begin(), now.vertices.end());
    for (const Int3 t : now.triangles) inside.triangles.push_back({t.x + first, t.y + first, t.z + first});
  }
  inside.normals = vertex_normals(inside);
}

/// Displacement of a kept node below the surface.
Vec3d inner_displacement(const sfem::Model& model, int slot, const std::vector<int>& from,
                         const std::vector<Vec3d>& forces) {
  TURGOR_CHECK(from.size() == forces.size(), "every loaded vertex has a force");
  Vec3d u;
  for (std::size_t f = 0; f < from.size(); f++) {
    if (model.free_node[std::size_t(from[f])] < 0) continue;
    std::array<double, 9> block{};
    sfem::green_block(model.green, slot, model.green.slot[std::size_t(from[f])], block);
    for (int axis = 0; axis < 3; axis++) {
      const double* column = &block[3 * std::size_t(axis)];
      u += Vec3d{column[0], column[1], column[2]} * forces[f][axis];
    }
  }
  return u;
}

/// Kept nodes below the surface that a snapshot needs: all of them for a finer surface, else those of
/// inclusions.
std::vector<int> shown_inner_slots(const SfemBody& body) {
  const sfem::Green& green = body.model.green;
  std::vector<std::uint8_t> snapshot(green.nodes.size(), body.seen ? 1 : 0);
  for (const InnerRegion& region : body.inside)
    for (const int v : region.vertices)
      if (const int slot = green.slot[std::size_t(v)]; slot >= 0) snapshot[std::size_t(slot)] = 1;
  std::vector<int> slots;
  for (std::size_t n = green.surface_count; n < snapshot.size(); n++)
    if (snapshot[n]) slots.push_back(int(n));
  return slots;
}

}  // namespace

std::vector<Vec3d> coarse_displacements(const Exec& exec, const SfemBody& body) {
  std::vector<Vec3d> displacement = displacements(exec, body, coarse_forces_now(body));
  TURGOR_CHECK(body.free.before.size() <= displacement.size(),
               "free motion is that of the vertices of the mesh");
  for (std::size_t v = 0; v < body.free.before.size(); v++) displacement[v] += body.free.before[v];
  return displacement;
}

std::vector<Vec3d> displacements(const Exec& exec, const SfemBody& body,
                                 std::span<const contact::VertexForce> vertex_forces) {
  const sfem::Green& green = body.model.green;
  std::vector<int> from;
  std::vector<Vec3d> forces;
  for (const auto& [vertex, force] : vertex_forces) from.push_back(vertex), forces.push_back(force);
  std::vector<float> u(3 * green.surface_count);
  sfem::surface_displacements(exec, body.model, from, flat(forces), u);
  std::vector<Vec3d> displacement(body.model.body.mesh.vertices.size());
  for (std::size_t n = 0; n < green.surface_count; n++)
    displacement[std::size_t(green.nodes[n])] = {u[3 * n], u[3 * n + 1], u[3 * n + 2]};
  const std::vector<int> inner = shown_inner_slots(body);
  parallel_for(exec, inner.size(), [&](std::size_t i) {
    displacement[std::size_t(green.nodes[std::size_t(inner[i])])] =
        inner_displacement(body.model, inner[i], from, forces);
  });
  return displacement;
}

std::vector<contact::VertexForce> coarse_forces_now(const SfemBody& body) {
  if (body.now.poses.empty()) return {};
  // viscosity.hpp: u = (Ξ f + Σ pᵢ vᵢ)/(1 + Σ pᵢ) after a tick, vᵢ = Ξ φᵢ
  const double p = total_ratio(body.now.viscosity);
  const std::vector<double> f = sfem::coarse_forces(*body.now.patch, flat(body.now.force));
  TURGOR_CHECK(f.size() == 3 * body.now.patch->coarse.size(), "three numbers a coarse vertex");
  std::map<int, Vec3d> forces;
  for (std::size_t c = 0; c < body.now.patch->coarse.size(); c++)
    forces[body.now.patch->coarse[c]] += Vec3d{f[3 * c], f[3 * c + 1], f[3 * c + 2]} / (1 + p);
  for (int pair = 0; pair < body.now.history.count; pair++) {
    const double own = body.now.viscosity.pairs[std::size_t(pair)].ratio / (1 + p);
    for (const contact::VertexForce& remembered :
         contact::coarse_history(body.now.history, pair, *body.now.patch))
      forces[remembered.vertex] += remembered.force * own;
  }
  std::vector<contact::VertexForce> list;
  for (const auto& [vertex, force] : forces) list.push_back({vertex, force});
  return list;
}

void show(const Exec& exec, const SfemBody& body, BodySnapshot& out) {
  TURGOR_ASSERT(body.now.patch != nullptr, "a snapshot of a touch has a patch");
  // displacement of the whole body
  std::vector<Vec3d> coarse(body.model.body.mesh.vertices.size());
  if (!body.now.poses.empty() || !body.free.before.empty()) coarse = coarse_displacements(exec, body);
  // contact pressure at patch points
  std::vector<double> pressure(body.now.patch->points.size());
  if (!body.now.poses.empty()) find_pressure(body, pressure);
  const std::vector<float> shown_pressure(pressure.begin(), pressure.end());
  // visible surface, or mesh surface joined with the patch
  if (body.seen)
    carry_surface(exec, body, coarse, shown_pressure, out);
  else
    join_surface(body, coarse, shown_pressure, out);
  // patch and inner regions
  out.wall_begin = out.triangles.size();
  update_vertices(out);
  show_coarse(body, out);
  show_patch(body, out.patch);
  show_inside(body, coarse, out.inside);
}

}  // namespace turgor
