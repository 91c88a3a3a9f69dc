#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <tuple>

#include "turgor/core/number_text.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/surface_edges.hpp"
#include "turgor/models/cloth/build/check_mesh.hpp"
#include "turgor/models/cloth/build/layers.hpp"
#include "turgor/models/cloth/build/numbering.hpp"
#include "turgor/models/cloth/forces/bending.hpp"
#include "turgor/models/cloth/forces/springs.hpp"

namespace turgor::cloth {

namespace {

/// The mesh in the model's numbering.
TriMesh renumbered(const TriMesh& mesh, const std::vector<int>& order, std::vector<int>& place) {
  TriMesh result;
  for (std::size_t n = 0; n < order.size(); n++) {
    place[std::size_t(order[n])] = int(n);
    result.vertices.push_back(mesh.vertices[std::size_t(order[n])]);
  }
  for (const auto [a, b, c] : mesh.triangles)
    result.triangles.push_back({place[std::size_t(a)], place[std::size_t(b)], place[std::size_t(c)]});
  std::stable_sort(result.triangles.begin(), result.triangles.end(), [](Int3 s, Int3 t) {
    return std::min({s.x, s.y, s.z}) < std::min({t.x, t.y, t.z});
  });
  return result;
}

/// Of each vertex, the first triangle whose smallest vertex is not below it; and the end.
std::vector<int> first_triangles(const TriMesh& mesh) {
  std::vector<int> begin(mesh.vertices.size() + 1, 0);
  for (const Int3 t : mesh.triangles) begin[std::size_t(std::min({t.x, t.y, t.z})) + 1]++;
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  return begin;
}

void set_masses(const TriMesh& mesh, double density, Model& model) {
  std::vector<double> mass(mesh.vertices.size(), 0);
  for (const auto [a, b, c] : mesh.triangles) {
    const Vec3d origin(mesh.vertices[std::size_t(a)]);
    const double area = norm(cross(Vec3d(mesh.vertices[std::size_t(b)]) - origin,
                                   Vec3d(mesh.vertices[std::size_t(c)]) - origin)) /
                        2;
    model.area += area;
    for (const int v : {a, b, c}) mass[std::size_t(v)] += density * area / 3;
  }
  model.total_mass = density * model.area;
  model.mass.assign(padded(mass.size()), 0);
  for (std::size_t v = 0; v < mass.size(); v++) model.mass[v] = Real(mass[v]);
}

/// Lengths of the mesh's edges, ascending [m].
std::vector<double> edge_lengths(const TriMesh& mesh) {
  std::vector<double> lengths;
  const std::vector<EdgeUse> uses = sorted_edges(mesh.triangles);
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    lengths.push_back(
        norm(Vec3d(mesh.vertices[std::size_t(edge[0].a)]) - Vec3d(mesh.vertices[std::size_t(edge[0].b)])));
  });
  std::sort(lengths.begin(), lengths.end());
  return lengths;
}

Status check_thickness(double thickness, const std::vector<double>& lengths) {
  const double median = lengths[lengths.size() / 2];
  if (thickness <= median) return Done{};
  return Error{"thickness: expected at most " + number_text(median) +
               " m, since half of the mesh's edges are shorter, found " + number_text(thickness) + " m"};
}

/// Pairs i < j that are adjacent or nearer than the thickness at rest.
NeighborLists near_at_rest(const TriMesh& mesh, const Vectors& x_rest, double thickness) {
  const std::size_t count = mesh.vertices.size();
  std::vector<std::vector<int>> lists(count, std::vector<int>{});
  for (const auto& t : mesh.triangles)
    for (int side = 0; side < 3; side++) {
      const int a = t[side], b = t[(side + 1) % 3];
      lists[std::size_t(std::min(a, b))].push_back(std::max(a, b));
    }
  SpatialHash near;
  sort_points(Exec(1), x_rest, int(count), Real(2.1 * thickness), near);
  NeighborLists result;
  result.begin.push_back(0);
  for (std::size_t i = 0; i < count; i++) {
    auto& list = lists[i];
    visit_near(near, x_rest[i], Real(thickness), [&](int j, Vec3) {
      if (j > int(i)) list.push_back(j);
    });
    sort_unique(list);
    result.item.insert(result.item.end(), list.begin(), list.end());
    result.begin.push_back(int(result.item.size()));
  }
  result.item.shrink_to_fit();
  return result;
}

/// Vertices alone keep two sheets apart when edges are about as long as the thickness: edges of √2 times that
/// which cross in their middles have ends as near as the thickness.
LargePrimitives coarse_mesh(const TriMesh& mesh, double thickness) {
  LargePrimitives coarse;
  const double limit = 1.5 * thickness;
  std::set<std::array<int, 2>> edges;
  for (const Int3 t : mesh.triangles) {
    double longest = 0;
    for (int side = 0; side < 3; side++)
      longest = std::max(longest, norm(Vec3d(mesh.vertices[std::size_t(t[side])]) -
                                       Vec3d(mesh.vertices[std::size_t(t[(side + 1) % 3])])));
    if (longest <= limit) continue;
    coarse.triangles.push_back(t);
    coarse.longest = std::max(coarse.longest, Real(longest));
    for (int side = 0; side < 3; side++)
      edges.insert({std::min(t[side], t[(side + 1) % 3]), std::max(t[side], t[(side + 1) % 3])});
  }
  coarse.edges.assign(edges.begin(), edges.end());
  return coarse;
}

void forget(aligned_vector<Real>& list) { list = aligned_vector<Real>(); }

/// The edges with what bending adds to them, and bending between vertices that no edge joins.
void make_sheet_rows(const TriMesh& mesh, std::vector<Spring> edges, Model& model) {
  const auto before = [](const Spring& s, const Spring& t) {
    return std::tie(s.a, s.b) < std::tie(t.a, t.b);
  };
  for (Spring& s : edges)
    if (s.a > s.b) std::swap(s.a, s.b);
  std::sort(edges.begin(), edges.end(), before);
  const std::vector<Spring> weights = bending_weights(mesh, model.params.fabric);
  std::vector<Spring> far;
  for (const Spring& s : weights) {
    const auto edge = std::lower_bound(edges.begin(), edges.end(), s, before);
    if (edge != edges.end() && edge->a == s.a && edge->b == s.b)
      edge->bend = s.bend;
    else
      far.push_back(s);
  }
  model.rows = make_rows(edges, model.count);
  model.far_rows = make_rows(far, model.count);
  for (auto* list : {&model.rows.rest, &model.far_rows.rest, &model.far_rows.stiffness}) forget(*list);
  const std::vector<double> lacking = lacking_weight(weights, model.count);
  model.spare.assign(model.mass.size(), 0);
  for (std::size_t v = 0; v < lacking.size(); v++) model.spare[v] = Real(lacking[v]);
  model.membrane = make_membrane(mesh, model.params.fabric);
  find_slots(mesh.triangles, model.rows, model.membrane);
}

void note_near_layers(const TriMesh& mesh, Model& model) {
  const double thickness = model.params.collision.thickness;
  if (const int count = vertices_near_other_layers(mesh, model.near, thickness); count > 0)
    model.notes.push_back(std::to_string(count) + " vertices lie nearer than the thickness of " +
                          number_text(thickness) +
                          " m to another layer of the mesh at rest: these do not keep out of each other; a "
                          "smaller collision.thickness, or weld for seams, would");
}

void number_model(const Numbering& numbering, Model& model) {
  model.count = int(numbering.order.size());
  model.original = numbering.order;
  model.part_begin = numbering.part_begin;
  model.place.resize(model.original.size());
}

}  // namespace

Result<Model> build(const Exec&, const TriMesh& given, const Params& params) {
  if (const Status s = check_params(params); !s) return s.error();
  if (const Status s = check_mesh(given); !s) return s.error();
  Model model{.params = params};
  std::vector<int> new_vertex;  // of each given one
  TriMesh mesh = given;
  if (params.weld > 0) {
    mesh = welded(given, params.weld, new_vertex);
    if (const Status s = check_mesh(mesh); !s)
      return Error{"after vertices closer than " + number_text(params.weld) + " m became one, " +
                   s.error().message};
    model.notes.push_back(std::to_string(given.vertices.size() - mesh.vertices.size()) +
                          " vertices closer than " + number_text(params.weld) + " m to another became one");
  }
  const std::vector<double> lengths = edge_lengths(mesh);
  if (params.collision.self)
    if (const Status s = check_thickness(params.collision.thickness, lengths); !s) return s.error();

  const bool is_sheet = params.fabric.law == Law::kSheet;
  if (const std::string crowded = crowded_edges(mesh); !crowded.empty())
    model.notes.push_back(crowded + (is_sheet ? ": nothing resists folding there"
                                              : ": every two of its triangles resist folding"));
  std::vector<Spring> springs =
      is_sheet ? membrane_springs(mesh, params.fabric) : make_springs(mesh, params.fabric);
  if (params.collision.self)
    if (const std::string folded = folded_edges(mesh); !folded.empty())
      model.notes.push_back(folded +
                            ": the triangles beside such an edge lie on each other at rest and may "
                            "pass through each other");
  number_model(number_vertices(springs, int(mesh.vertices.size())), model);
  mesh = renumbered(mesh, model.original, model.place);
  for (Spring& s : springs) s.a = model.place[std::size_t(s.a)], s.b = model.place[std::size_t(s.b)];
  set_masses(mesh, params.fabric.density, model);
  if (is_sheet) {
    make_sheet_rows(mesh, springs, model);
  } else {
    model.rows = make_rows(springs, model.count);
    forget(model.rows.bend);
  }
  model.spring_count = springs.size();
  for (const double length : lengths) model.mean_edge += length / double(lengths.size());
  model.shortest_edge = lengths[0];
  model.triangles = mesh.triangles;
  model.triangle_begin = first_triangles(mesh);
  model.chunk_triangles = triangles_by_chunk(model.triangles, model.mass.size());
  model.x_rest.resize(model.mass.size());
  for (std::size_t v = 0; v < mesh.vertices.size(); v++) model.x_rest.set(v, mesh.vertices[v]);
  if (params.collision.self) {
    model.near = near_at_rest(mesh, model.x_rest, params.collision.thickness);
    note_near_layers(mesh, model);
    model.coarse = coarse_mesh(mesh, params.collision.thickness);
  }
  if (params.solver.method == Method::kBlocks) model.blocks = make_blocks(model);
  if (!new_vertex.empty()) {  // numbers of the mesh that was given
    for (int& v : new_vertex) v = model.place[std::size_t(v)];
    for (std::size_t v = new_vertex.size(); v-- > 0;) model.original[std::size_t(new_vertex[v])] = int(v);
    model.place = std::move(new_vertex);
  }
  if (const std::size_t parts = model.part_begin.size() - 1; parts > 1)
    model.notes.push_back("the mesh has " + std::to_string(parts) + " parts that no edge joins");
  return model;
}

State make_state(const Model& model) {
  State state{.x = model.x_rest};
  const std::size_t size = model.mass.size(), entries = model.rows.stiffness.size();
  System& system = state.system;
  for (Vectors* field :
       {&state.v, &system.force, &system.inverse[0], &system.inverse[1], &system.change, &system.before})
    field->resize(size);
  system.along.resize(entries), system.across.resize(entries);
  state.free_mass = model.mass;
  return state;
}

}  // namespace turgor::cloth
