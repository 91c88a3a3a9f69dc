#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/geometry/quadratic.hpp"
#include "turgor/geometry/triangle_tree.hpp"
#include "turgor/models/sfem/check_body.hpp"
#include "turgor/models/sfem/elements.hpp"
#include "turgor/models/sfem/fields.hpp"
#include "turgor/models/sfem/inertia.hpp"

namespace turgor::sfem {

namespace {

/// Numbers the vertices that elements use and nothing fixes.
void number_free_nodes(Model& model) {
  const Body& body = model.body;
  TURGOR_CHECK(body.fixed.size() == body.mesh.vertices.size(), "every vertex has a mark");
  model.free_node.assign(body.mesh.vertices.size(), -1);
  for (const int v : body.mesh.elements)
    if (!body.fixed[std::size_t(v)]) model.free_node[std::size_t(v)] = 0;
  for (std::size_t v = 0; v < model.free_node.size(); v++)
    if (model.free_node[v] == 0) {
      model.free_node[v] = int(model.vertex.size());
      model.vertex.push_back(int(v));
    }
}

/// The rows and columns of free nodes.
BlockMatrix restricted(const BlockMatrix& all, const Model& model) {
  BlockMatrix k;
  k.row_begin.assign(1, 0);
  // copy the blocks between free nodes
  for (const int v : model.vertex) {
    for (std::size_t b = all.row_begin[std::size_t(v)]; b < all.row_begin[std::size_t(v) + 1]; b++) {
      const int column = model.free_node[std::size_t(all.column[b])];
      if (column < 0) continue;
      k.column.push_back(column);
      k.value.insert(k.value.end(), &all.value[9 * b], &all.value[9 * b] + 9);
    }
    // close the row
    k.row_begin.push_back(k.column.size());
  }
  TURGOR_CHECK(is_csr(k.row_begin, k.column.size()) && k.value.size() == 9 * k.column.size(),
               "the rows cover all blocks, of nine numbers each");
  return k;
}

/// 1 for every element that has a face in the surface, or its centroid at most `depth` [m] from it.
std::vector<std::uint8_t> near_surface(const Exec& exec, const SolidMesh& mesh, const SolidSurface& surface,
                                       double depth) {
  std::vector<std::uint8_t> near(element_count(mesh), 0);
  for (const int e : surface.element) near[std::size_t(e)] = 1;
  const TriangleTree tree = build_triangle_tree(mesh.vertices, surface.triangles);
  parallel_for(
      exec, near.size(),
      [&](std::size_t e) {
        if (!near[e]) near[e] = nearest_point(tree, centroid(mesh, e)).distance <= depth;
      },
      64);
  return near;
}

/// The free vertices of the surface, then those of the elements that a tool can reach.
void choose_kept_nodes(const Exec& exec, Model& model) {
  const SolidMesh& mesh = model.body.mesh;
  const std::vector<std::uint8_t> near = near_surface(exec, mesh, model.surface, model.params.touch_depth);
  std::vector<std::uint8_t> wanted(mesh.vertices.size(), 0);  // 1: near the surface, 2: on it
  for (std::size_t e = 0; e < near.size(); e++)
    if (near[e])
      for (const int v : element(mesh, e)) wanted[std::size_t(v)] = 1;
  for (const auto [a, b, c] : model.surface.triangles)
    wanted[std::size_t(a)] = wanted[std::size_t(b)] = wanted[std::size_t(c)] = 2;

  Green& green = model.green;
  green.slot.assign(mesh.vertices.size(), -1);
  for (const std::uint8_t kind : {2, 1}) {
    for (const int v : model.vertex)
      if (wanted[std::size_t(v)] == kind) {
        green.slot[std::size_t(v)] = int(green.nodes.size());
        green.nodes.push_back(v);
      }
    if (kind == 2) green.surface_count = green.nodes.size();
  }
}

}  // namespace

Body with_middles(Body body) {
  body.mesh = with_middles(body.mesh);
  fix_middles(body);
  return body;
}

void fix_middles(Body& body) {
  body.fixed.resize(body.mesh.vertices.size(), 0);
  for (std::size_t e = 0; e < element_count(body.mesh); e++) {
    const std::span<const int> nodes = element(body.mesh, e);
    const auto is_fixed = [&](int node) { return body.fixed[std::size_t(nodes[std::size_t(node)])] != 0; };
    for (const auto [a, b] : kTetEdges)
      if (is_fixed(a) && is_fixed(b)) body.fixed[std::size_t(nodes[std::size_t(node_between(a, b))])] = 1;
  }
}

Result<Model> build(const Exec& exec, Body body, const Params& params) {
  // check
  if (const Status fit = check_body(body, params.density > 0); !fit) return fit.error();
  if (!(params.touch_depth >= 0)) return Error{"touch_depth must be 0 m or more"};
  Model model;
  model.body = std::move(body);
  model.params = params;
  // topology
  model.surface = surface(model.body.mesh);
  model.neighbors = face_neighbors(model.body.mesh);
  number_free_nodes(model);
  // stiffness of the free nodes
  const BlockMatrix all = assemble(exec, model.body.mesh, model.body.materials, element_materials(model.body),
                                   params.formulation);
  model.stiffness = restricted(all, model);
  if (params.density > 0) {
    model.mass = lumped_masses(model.body.mesh, params.density);
    add_inertia(model);
  }
  // nodes with Green's functions
  choose_kept_nodes(exec, model);
  TURGOR_CHECK(model.green.surface_count <= model.green.nodes.size(), "the nodes of the surface are kept");
  return model;
}

std::size_t memory_bytes(const Model& model) { return bytes_of_fields(model); }

std::uint64_t content_hash(const Model& model) {
  constexpr std::uint64_t kVersion = 1;  // of what the store holds and how it is computed
  const Body& body = model.body;
  const std::vector<int> material = element_materials(body);
  std::vector<double> numbers;
  for (const Vec3d x : body.mesh.vertices) numbers.insert(numbers.end(), {x.x, x.y, x.z});
  for (const int m : material) {
    numbers.push_back(body.materials[std::size_t(m)].young);
    numbers.push_back(body.materials[std::size_t(m)].poisson);
  }
  const std::uint64_t header[] = {kVersion, std::uint64_t(body.mesh.corners),
                                  std::uint64_t(model.params.formulation),
                                  std::uint64_t(model.params.precision)};
  std::uint64_t hash = hash_values(std::span<const std::uint64_t>(header));
  hash = hash_values(std::span<const double>(numbers), hash);
  hash = hash_values(std::span<const int>(body.mesh.elements), hash);
  hash = hash_values(std::span<const int>(model.vertex), hash);
  if (!model.mass.empty()) {
    const double inertia[] = {model.params.density, model.params.time_step};
    hash = hash_values(std::span<const double>(inertia), hash);
  }
  return hash_values(std::span<const int>(model.green.nodes), hash);
}

}  // namespace turgor::sfem
