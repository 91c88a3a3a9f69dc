#include "turgor/models/sfem/patch_assembly.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/quadratic.hpp"
#include "turgor/models/sfem/elements.hpp"
#include "turgor/models/sfem/patch_scatter.hpp"

namespace turgor::sfem {

namespace {

template <std::size_t N>
std::array<Vec3d, N> fine_corners(const FineMesh& fine, std::size_t e) {
  std::array<Vec3d, N> x;
  for (std::size_t c = 0; c < N; c++) x[c] = fine.nodes[std::size_t(fine.corners[N * e + c])].x;
  return x;
}
template <std::size_t N>
std::array<Vec3d, N> coarse_corners(const SolidMesh& mesh, int e) {
  std::array<Vec3d, N> x;
  for (std::size_t c = 0; c < N; c++) x[c] = mesh.vertices[std::size_t(element(mesh, std::size_t(e))[c])];
  return x;
}

/// True when the hexahedron is the affine image of a cube.
bool is_parallelepiped(const std::array<Vec3d, 8>& x) {
  const Vec3d a = x[1] - x[0], b = x[3] - x[0], c = x[4] - x[0];
  const double scale = norm(a) + norm(b) + norm(c);
  const auto differs = [&](Vec3d corner, Vec3d expected) {
    return norm(corner - x[0] - expected) > 1e-10 * scale;
  };
  return !(differs(x[2], a + b) || differs(x[5], a + c) || differs(x[6], a + b + c) || differs(x[7], b + c));
}

/// True when the quadratic tetrahedron is the affine image of one with straight edges.
bool is_straight(const std::array<Vec3d, 10>& x) {
  double scale = 0, off = 0;
  for (std::size_t e = 0; e < kTetEdges.size(); e++) {
    const Vec3d a = x[std::size_t(kTetEdges[e][0])], b = x[std::size_t(kTetEdges[e][1])];
    scale = std::max(scale, norm(b - a));
    off = std::max(off, norm(x[4 + e] - (a + b) / 2));
  }
  return off <= 1e-10 * scale;
}

/// True when all fine elements of one shape in this coarse element have the same stiffness.
bool has_congruent_parts(const SolidMesh& mesh, int e) {
  if (mesh.corners == 8) return is_parallelepiped(coarse_corners<8>(mesh, e));
  return mesh.corners == 4 || is_straight(coarse_corners<10>(mesh, e));
}

/// Material at a position inside a coarse element.
int material_at(const Body& body, int e, Vec3d x) {
  int material = body.material.empty() ? 0 : body.material[std::size_t(e)];
  for (const Inclusion& sphere : body.inclusions)
    if (norm(x - sphere.center) <= sphere.radius) material = sphere.material;
  return material;
}

/// Stiffness of the fine elements of one coarse element. Congruent ones of one material share theirs.
template <std::size_t N>
class PartStiffness {
 public:
  PartStiffness(const Model& model, const FineMesh& fine) : model_(model), fine_(fine) {}

  const double* operator()(std::size_t f, int material) {
    // a new coarse element
    if (fine_.parent[f] != parent_) {
      parent_ = fine_.parent[f];
      made_for_.fill(-1);
      congruent_ = has_congruent_parts(model_.body.mesh, parent_);
    }
    const auto shape = std::size_t(fine_.shape[f]);
    auto& k = stiffness_[shape];
    // reuse the matrix of a congruent element
    if (congruent_ && made_for_[shape] == material) return k.data();
    made_for_[shape] = material;
    // compute
    const Material& m = model_.body.materials[std::size_t(material)];
    if constexpr (N == 8)
      hex_stiffness(fine_corners<8>(fine_, f), m, model_.params.formulation, k);
    else if constexpr (N == 10)
      quadratic_stiffness(fine_corners<10>(fine_, f), m, k);
    else
      tet_stiffness(fine_corners<4>(fine_, f), m, k);
    return k.data();
  }

 private:
  static constexpr std::size_t kShapes = 6;
  const Model& model_;
  const FineMesh& fine_;
  int parent_ = -1;
  bool congruent_ = true;
  std::array<int, kShapes> made_for_{};  // material
  std::array<std::array<double, 9 * N * N>, kShapes> stiffness_;
};

template <std::size_t N, class Scatter>
void add_parts(const Model& model, const FineMesh& fine, const std::vector<int>& material, Scatter& scatter) {
  PartStiffness<N> stiffness(model, fine);
  ElementScatter<Scatter, N> of_element(model.body.mesh, fine, scatter);
  for (std::size_t f = 0; f < fine.parent.size(); f++) {
    if (f == 0 || fine.parent[f] != fine.parent[f - 1])
      of_element.begin(fine.parent[f]), scatter.begin_element(f);
    of_element.add(&fine.corners[N * f], stiffness(f, material[f]));
    if (f + 1 == fine.parent.size() || fine.parent[f + 1] != fine.parent[f]) of_element.end();
  }
}

/// Node-averaged tetrahedra: a node's dilatation couples all elements around it.
template <class T>
void add_averaged_tets(const Exec& exec, const Model& model, const FineMesh& fine,
                       const std::vector<int>& material, PatchScatter<T>& scatter) {
  SolidMesh mesh;
  for (const FineNode& node : fine.nodes) mesh.vertices.push_back(node.x);
  mesh.elements = fine.corners;
  const BlockMatrix k = assemble(exec, mesh, model.body.materials, material, Formulation::kAveraged);
  for (std::size_t a = 0; a + 1 < k.row_begin.size(); a++)
    for (std::size_t i = k.row_begin[a]; i < k.row_begin[a + 1]; i++) {
      const FineNode& column = fine.nodes[std::size_t(k.column[i])];
      scatter.add_local(int(a), k.column[i], &k.value[9 * i], 3);
      for (std::size_t s = 0; s < std::size_t(column.supports); s++)
        scatter.add_coarse_column(int(a), column.coarse[s], &k.value[9 * i], 3, column.weight[s]);
    }
}

/// Adds the stiffness of these coarse elements, as they are among themselves, to the change.
template <class Scatter>
void add_coarse(const Exec& exec, const Model& model, const std::vector<int>& elements, double scale,
                Scatter& scatter) {
  if (elements.empty()) return;
  SolidMesh mesh;
  mesh.corners = model.body.mesh.corners;
  std::vector<int> vertices, material;
  for (const int e : elements) {
    const auto corners = element(model.body.mesh, std::size_t(e));
    vertices.insert(vertices.end(), corners.begin(), corners.end());
    material.push_back(material_at(model.body, e, centroid(model.body.mesh, std::size_t(e))));
  }
  const std::vector<int> corners = vertices;
  sort_unique(vertices);
  for (const int v : vertices) mesh.vertices.push_back(model.body.mesh.vertices[std::size_t(v)]);
  for (const int v : corners)
    mesh.elements.push_back(int(std::lower_bound(vertices.begin(), vertices.end(), v) - vertices.begin()));
  const BlockMatrix k = assemble(exec, mesh, model.body.materials, material, model.params.formulation);
  for (std::size_t a = 0; a < vertices.size(); a++)
    for (std::size_t i = k.row_begin[a]; i < k.row_begin[a + 1]; i++)
      scatter.add_change(vertices[a], vertices[std::size_t(k.column[i])], &k.value[9 * i], 3, scale);
}

template <std::size_t N>
PatchPieces pieces_of(const Model& model, std::span<const int> elements, const FineMesh& fine,
                      const PatchUnknowns& unknowns, bool with_change) {
  PieceScatter<N> scatter(model.body.mesh, fine, unknowns, with_change);
  add_parts<N>(model, fine, fine_materials(model, fine), scatter);
  if (with_change) add_coarse(Exec(1), model, {elements.begin(), elements.end()}, -1, scatter);
  return scatter.take();
}

}  // namespace

std::vector<int> fine_materials(const Model& model, const FineMesh& fine) {
  const std::size_t n = std::size_t(model.body.mesh.corners);
  std::vector<int> material(fine.parent.size());
  for (std::size_t f = 0; f < material.size(); f++) {
    Vec3d center;
    for (std::size_t c = 0; c < n; c++) center += fine.nodes[std::size_t(fine.corners[n * f + c])].x;
    material[f] = material_at(model.body, fine.parent[f], center / double(n));
  }
  return material;
}

PatchPieces assemble_pieces(const Model& model, std::span<const int> elements, const FineMesh& fine,
                            const PatchUnknowns& unknowns, bool with_change) {
  TURGOR_ASSERT(!averages_nodes(model.body.mesh, model.params.formulation),
                "pieces are those of elements that do not couple across their faces");
  if (model.body.mesh.corners == 8) return pieces_of<8>(model, elements, fine, unknowns, with_change);
  if (model.body.mesh.corners == 10) return pieces_of<10>(model, elements, fine, unknowns, with_change);
  return pieces_of<4>(model, elements, fine, unknowns, with_change);
}

bool changes_stiffness(const Model& model, std::span<const int> elements, const FineMesh& fine) {
  const SolidMesh& mesh = model.body.mesh;
  if (model.params.formulation == Formulation::kAveraged && mesh.corners != 10) return true;
  for (const int e : elements)
    if (!has_congruent_parts(mesh, e)) return true;
  if (model.body.inclusions.empty()) return false;
  const std::vector<int> material = fine_materials(model, fine);
  for (std::size_t f = 0; f < material.size(); f++) {
    const int e = fine.parent[f];
    if (material[f] != material_at(model.body, e, centroid(mesh, std::size_t(e)))) return true;
  }
  return false;
}

std::vector<int> changed_elements(const Model& model, std::span<const int> elements) {
  const SolidMesh& mesh = model.body.mesh;
  std::vector<int> changed(elements.begin(), elements.end());
  if (!averages_nodes(mesh, model.params.formulation)) return changed;
  // vertices of the patch
  std::vector<char> of_patch(mesh.vertices.size(), 0);
  for (const int e : elements)
    for (const int v : element(mesh, std::size_t(e))) of_patch[std::size_t(v)] = 1;
  // elements around them
  changed.clear();
  for (std::size_t e = 0; e < element_count(mesh); e++) {
    const auto corners = element(mesh, e);
    if (std::any_of(corners.begin(), corners.end(), [&](int v) { return of_patch[std::size_t(v)]; }))
      changed.push_back(int(e));
  }
  return changed;
}

template <class T>
PatchMatrices<T> assemble_patch(const Model& model, std::span<const int> elements, const FineMesh& fine,
                                const PatchUnknowns& unknowns, bool with_change) {
  const Exec alone(1);
  const std::vector<int> material = fine_materials(model, fine);
  PatchScatter<T> scatter(fine, unknowns, model.body.mesh.vertices.size(), with_change);
  if (model.body.mesh.corners == 8)
    add_parts<8>(model, fine, material, scatter);
  else if (model.body.mesh.corners == 10)
    add_parts<10>(model, fine, material, scatter);
  else if (averages_nodes(model.body.mesh, model.params.formulation))
    add_averaged_tets(alone, model, fine, material, scatter);
  else
    add_parts<4>(model, fine, material, scatter);
  if (with_change) {
    // The coarse stiffness contains the patch's elements. The fine ones replace them, and the remaining
    // coarse elements around the patch are averaged among themselves.
    const std::vector<int> before = changed_elements(model, elements);
    std::vector<int> after;
    std::set_difference(before.begin(), before.end(), elements.begin(), elements.end(),
                        std::back_inserter(after));
    add_coarse(alone, model, before, -1, scatter);
    add_coarse(alone, model, after, 1, scatter);
  }
  return scatter.take();
}

template PatchMatrices<float> assemble_patch(const Model&, std::span<const int>, const FineMesh&,
                                             const PatchUnknowns&, bool);
template PatchMatrices<double> assemble_patch(const Model&, std::span<const int>, const FineMesh&,
                                              const PatchUnknowns&, bool);

}  // namespace turgor::sfem
