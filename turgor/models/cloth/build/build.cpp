#include "turgor/models/cloth/build/build.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/number_text.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/surface_edges.hpp"
#include "turgor/models/cloth/build/check_mesh.hpp"
#include "turgor/models/cloth/build/large.hpp"
#include "turgor/models/cloth/build/layers.hpp"
#include "turgor/models/cloth/build/numbering.hpp"
#include "turgor/models/cloth/contact/spatial_hash.hpp"
#include "turgor/models/cloth/forces/bending.hpp"
#include "turgor/models/cloth/forces/membrane.hpp"
#include "turgor/models/cloth/forces/slivers.hpp"
#include "turgor/models/cloth/forces/springs.hpp"
#include "turgor/models/cloth/forces/wind.hpp"
#include "turgor/models/cloth/model/contacts.hpp"
#include "turgor/models/cloth/model/mesh_tables.hpp"
#include "turgor/models/cloth/solver/two_level.hpp"

namespace turgor::cloth {

namespace {

/// Mesh in the numbering of the model, with triangles sorted by their smallest vertex.
TriMesh renumbered(const TriMesh& mesh, const std::vector<int>& order, std::vector<int>& model_vertex) {
  TURGOR_CHECK(is_permutation(order, mesh.vertices.size()), "an order has every vertex once");
  TURGOR_CHECK(model_vertex.size() == order.size(), "every vertex has an index in the order");
  TriMesh result;
  for (std::size_t n = 0; n < order.size(); n++) {
    model_vertex[std::size_t(order[n])] = int(n);
    result.vertices.push_back(mesh.vertices[std::size_t(order[n])]);
  }
  for (const auto [a, b, c] : mesh.triangles)
    result.triangles.push_back(
        {model_vertex[std::size_t(a)], model_vertex[std::size_t(b)], model_vertex[std::size_t(c)]});
  std::stable_sort(result.triangles.begin(), result.triangles.end(), [](Int3 s, Int3 t) {
    return std::min({s.x, s.y, s.z}) < std::min({t.x, t.y, t.z});
  });
  return result;
}

/// First triangle of each smallest vertex, and the end.
std::vector<int> first_triangles(const TriMesh& mesh) {
  std::vector<int> begin(mesh.vertices.size() + 1, 0);
  for (const Int3 t : mesh.triangles) begin[std::size_t(std::min({t.x, t.y, t.z})) + 1]++;
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  TURGOR_CHECK(is_csr(begin, mesh.triangles.size()), "every triangle has a smallest vertex");
  return begin;
}

/// Lumped masses: a third of each triangle's mass per corner.
void set_masses(const TriMesh& mesh, double density, Model& model) {
  TURGOR_CHECK(density > 0, "cloth has a mass");
  // distribute triangle masses to corners
  std::vector<double> mass(mesh.vertices.size(), 0);
  for (const auto [a, b, c] : mesh.triangles) {
    const Vec3d origin(mesh.vertices[std::size_t(a)]);
    const double area = norm(cross(Vec3d(mesh.vertices[std::size_t(b)]) - origin,
                                   Vec3d(mesh.vertices[std::size_t(c)]) - origin)) /
                        2;
    TURGOR_CHECK(area > 0, "a triangle has an area");
    model.area += area;
    for (const int v : {a, b, c}) mass[std::size_t(v)] += density * area / 3;
  }
  // store totals and padded vertex masses
  model.total_mass = density * model.area;
  model.mass.assign(padded(mass.size()), 0);
  for (std::size_t v = 0; v < mass.size(); v++) model.mass[v] = Real(mass[v]);
}

/// Edge lengths, ascending [m].
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
  TURGOR_CHECK(!lengths.empty() && is_ascending(lengths), "edges are sorted by length");
  const double median = lengths[lengths.size() / 2];
  if (thickness <= median) return Done{};
  return Error{"thickness: expected at most " + number_text(median) +
               " m, since half of the mesh's edges are shorter, found " + number_text(thickness) + " m"};
}

/// Pairs i < j without contact: adjacent, or closer than the thickness at rest.
NeighborLists excluded_pairs(const TriMesh& mesh, const Vectors& x_rest, double thickness) {
  TURGOR_CHECK(thickness > 0, "contacts have a thickness");
  const std::size_t count = mesh.vertices.size();
  // adjacent pairs
  std::vector<std::vector<int>> lists(count, std::vector<int>{});
  for (const auto& t : mesh.triangles)
    for (int side = 0; side < 3; side++) {
      const int a = t[side], b = t[(side + 1) % 3];
      lists[std::size_t(std::min(a, b))].push_back(std::max(a, b));
    }
  // pairs closer than the thickness
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
  TURGOR_CHECK(is_csr(result.begin, result.item.size()), "every vertex has a list of near vertices");
  return result;
}

void clear(aligned_vector<Real>& list) { list = aligned_vector<Real>(); }

/// Rows of a sheet: edges with membrane stiffness and bending, and bending between vertices without a common
/// edge.
void make_sheet_rows(const TriMesh& mesh, std::vector<Spring> edges, Model& model) {
  // edges, ascending by their vertices
  const auto before = [](const Spring& s, const Spring& t) {
    return std::tie(s.a, s.b) < std::tie(t.a, t.b);
  };
  for (Spring& s : edges)
    if (s.a > s.b) std::swap(s.a, s.b);
  std::sort(edges.begin(), edges.end(), before);
  // bending weights of edges and of other pairs
  const std::vector<char> is_sliver = find_slivers(mesh);
  const std::vector<Spring> weights = bending_weights(mesh, model.params.fabric, is_sliver);
  std::vector<Spring> far;
  for (const Spring& s : weights) {
    const auto edge = std::lower_bound(edges.begin(), edges.end(), s, before);
    if (edge != edges.end() && edge->a == s.a && edge->b == s.b)
      edge->bend = s.bend;
    else
      far.push_back(s);
  }
  // rows
  model.rows = make_rows(edges, model.count);
  model.far_rows = make_rows(far, model.count);
  for (auto* list : {&model.rows.rest, &model.far_rows.rest, &model.far_rows.stiffness}) clear(*list);
  // additional diagonal of bending
  const std::vector<double> missing = missing_diagonal(weights, model.count);
  model.extra_diagonal.assign(model.mass.size(), 0);
  TURGOR_CHECK(missing.size() <= model.extra_diagonal.size(), "every vertex has a diagonal");
  for (std::size_t v = 0; v < missing.size(); v++) model.extra_diagonal[v] = Real(missing[v]);
  // membrane
  model.membrane = make_membrane(mesh, model.params.fabric, is_sliver);
  find_slots(mesh.triangles, model.rows, model.membrane);
}

void note_near_layers(const TriMesh& mesh, Model& model) {
  const double thickness = model.params.collision.thickness;
  if (const int count = vertices_near_other_layers(mesh, model.excluded, thickness); count > 0)
    model.notes.push_back(std::to_string(count) + " vertices are closer than the thickness of " +
                          number_text(thickness) +
                          " m to another layer of the mesh at rest, so contacts do not keep them apart; "
                          "use a smaller collision.thickness, or weld for seams");
}

void number_model(const Numbering& numbering, Model& model) {
  TURGOR_CHECK(is_csr(numbering.component_begin, numbering.order.size()), "components cover all vertices");
  model.count = int(numbering.order.size());
  model.original = numbering.order;
  model.component_begin = numbering.component_begin;
  model.model_vertex.resize(model.original.size());
}

}  // namespace

Result<Model> build(const Exec&, const TriMesh& given, const Params& params) {
  // checks
  if (const Status s = check_params(params); !s) return s.error();
  if (const Status s = check_mesh(given); !s) return s.error();
  Model model{.params = params};
  std::vector<int> new_vertex;  // number of each input vertex after welding
  TriMesh mesh = given;
  if (params.weld > 0) {
    mesh = welded(given, params.weld, new_vertex);
    if (const Status s = check_mesh(mesh); !s)
      return Error{"after merging vertices closer than " + number_text(params.weld) +
                   " m: " + s.error().message};
    model.notes.push_back(std::to_string(given.vertices.size() - mesh.vertices.size()) +
                          " vertices closer than " + number_text(params.weld) + " m to another were merged");
  }
  const std::vector<double> lengths = edge_lengths(mesh);
  if (params.collision.self)
    if (const Status s = check_thickness(params.collision.thickness, lengths); !s) return s.error();

  // springs and notes about unusual edges
  const bool is_sheet = params.fabric.law == Law::kSheet;
  if (const std::string crowded = crowded_edges(mesh); !crowded.empty())
    model.notes.push_back(crowded + (is_sheet ? ": these edges do not resist folding"
                                              : ": each pair of their triangles resists folding"));
  const std::vector<char> is_sliver = is_sheet ? find_slivers(mesh) : std::vector<char>();
  std::vector<Spring> springs =
      is_sheet ? membrane_springs(mesh, params.fabric, is_sliver) : make_springs(mesh, params.fabric);
  if (const auto count = std::count(is_sliver.begin(), is_sliver.end(), char(1)); count > 0)
    model.notes.push_back(std::to_string(count) + (count == 1 ? " triangle is" : " triangles are") +
                          " thinner than a tenth of those around: such triangles carry no force, their edges "
                          "do not resist folding, and they pass through the cloth");
  if (params.collision.self)
    if (const std::string folded = folded_edges(mesh); !folded.empty())
      model.notes.push_back(folded +
                            ": the triangles of such an edge touch at rest and may "
                            "pass through each other");
  // numbering
  number_model(number_vertices(springs, int(mesh.vertices.size())), model);
  mesh = renumbered(mesh, model.original, model.model_vertex);
  for (Spring& s : springs)
    s.a = model.model_vertex[std::size_t(s.a)], s.b = model.model_vertex[std::size_t(s.b)];
  // masses and rows
  set_masses(mesh, params.fabric.density, model);
  if (is_sheet) {
    make_sheet_rows(mesh, springs, model);
  } else {
    model.rows = make_rows(springs, model.count);
    clear(model.rows.bend);
  }
  // edges, triangles and rest positions
  model.spring_count = springs.size();
  for (const double length : lengths) model.mean_edge += length / double(lengths.size());
  model.shortest_edge = lengths[0];
  model.triangles = mesh.triangles;
  model.triangle_begin = first_triangles(mesh);
  model.chunk_triangles = triangles_by_chunk(model.triangles, model.mass.size());
  model.x_rest.resize(model.mass.size());
  for (std::size_t v = 0; v < mesh.vertices.size(); v++) model.x_rest.set(v, mesh.vertices[v]);
  // tables of contact
  if (params.collision.self) {
    model.excluded = excluded_pairs(mesh, model.x_rest, params.collision.thickness);
    note_near_layers(mesh, model);
    model.large = find_large_primitives(mesh, model.membrane, params.collision.thickness);
  }
  // blocks of the preconditioner
  if (params.solver.method == Method::kTwoLevel) model.blocks = make_blocks(model);
  if (!new_vertex.empty()) {  // numbers of the input mesh
    for (int& v : new_vertex) v = model.model_vertex[std::size_t(v)];
    for (std::size_t v = new_vertex.size(); v-- > 0;) model.original[std::size_t(new_vertex[v])] = int(v);
    model.model_vertex = std::move(new_vertex);
  }
  TURGOR_CHECK(model.model_vertex.size() == given.vertices.size(),
               "every vertex of the input has a model vertex");
  TURGOR_CHECK(all_indices(model.model_vertex, std::size_t(model.count)),
               "every vertex of the input is one of the model");
  if (const std::size_t components = model.component_begin.size() - 1; components > 1)
    model.notes.push_back("the mesh has " + std::to_string(components) + " connected components");
  return model;
}

State make_state(const Model& model) {
  State state{.x = model.x_rest};
  const std::size_t size = model.mass.size(), entries = model.rows.stiffness.size();
  TURGOR_CHECK(state.x.size() == size, "every vertex has a position and a mass");
  System& system = state.system;
  for (Vectors* field :
       {&state.v, &system.force, &system.inverse[0], &system.inverse[1], &system.change, &system.previous})
    field->resize(size);
  system.along.resize(entries), system.across.resize(entries);
  state.free_mass = model.mass;
  return state;
}

}  // namespace turgor::cloth
