#include "turgor/models/sfem/patch_assembly.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/models/sfem/elements.hpp"

namespace turgor::sfem {

namespace {

/// Puts blocks between fine nodes where they belong. u = N u_G + u_L, so a block between nodes a and b is one
/// of K_L, one of K_LG for every coarse vertex b hangs on, and, when asked for, one of Nᵀ K N for all pairs.
template <class T>
class PatchScatter {
 public:
  PatchScatter(const FineMesh& fine, const PatchUnknowns& unknowns, std::size_t vertices, bool with_change)
      : fine_(fine),
        unknowns_(unknowns),
        index_(vertices, -1),
        local_rows_(3 * std::size_t(unknowns.local_count)),
        coarse_rows_(3 * unknowns.coarse.size()),
        with_change_(with_change) {
    for (std::size_t i = 0; i < unknowns.coarse.size(); i++) index_[std::size_t(unknowns.coarse[i])] = int(i);
    matrices_.local.assign(local_rows_ * local_rows_, 0);
    matrices_.coupling.assign(local_rows_ * coarse_rows_, 0);
    if (with_change) matrices_.change.assign(coarse_rows_ * coarse_rows_, 0);
  }

  /// Row a, column b; `block` row by row with this distance between rows.
  void add(int a, int b, const double* block, std::size_t stride) {
    const FineNode &row = fine_.nodes[std::size_t(a)], &column = fine_.nodes[std::size_t(b)];
    const int local_row = unknowns_.local[std::size_t(a)], local_column = unknowns_.local[std::size_t(b)];
    if (local_row >= 0) {
      if (local_column >= 0 && local_column <= local_row)
        add_block(matrices_.local, local_rows_, local_row, local_column, block, stride, 1);
      for (int s = 0; s < column.supports; s++)
        add_block(matrices_.coupling, local_rows_, local_row, index_of(column, s), block, stride,
                  column.weight[std::size_t(s)]);
    }
    if (!with_change_) return;
    for (int r = 0; r < row.supports; r++)
      for (int s = 0; s < column.supports; s++)
        add_block(matrices_.change, coarse_rows_, index_of(row, r), index_of(column, s), block, stride,
                  row.weight[std::size_t(r)] * column.weight[std::size_t(s)]);
  }
  /// Adds to the change between two coarse vertices, which may be fixed.
  void add_coarse(int vertex_row, int vertex_column, const double* block, std::size_t stride, double scale) {
    const int row = index_[std::size_t(vertex_row)], column = index_[std::size_t(vertex_column)];
    if (row >= 0 && column >= 0) add_block(matrices_.change, coarse_rows_, row, column, block, stride, scale);
  }
  PatchMatrices<T> take() { return std::move(matrices_); }

 private:
  int index_of(const FineNode& node, int support) const {
    return index_[std::size_t(node.coarse[std::size_t(support)])];
  }
  static void add_block(std::vector<T>& matrix, std::size_t rows, int row, int column, const double* block,
                        std::size_t stride, double scale) {
    T* at = matrix.data() + 3 * std::size_t(column) * rows + 3 * std::size_t(row);
    for (std::size_t c = 0; c < 3; c++)
      for (std::size_t r = 0; r < 3; r++) at[c * rows + r] += T(scale * block[r * stride + c]);
  }

  const FineMesh& fine_;
  const PatchUnknowns& unknowns_;
  std::vector<int> index_;  // of each vertex among the coarse unknowns
  std::size_t local_rows_, coarse_rows_;
  bool with_change_;
  PatchMatrices<T> matrices_;
};

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

/// Is the hexahedron the affine image of a cube?
bool is_parallelepiped(const std::array<Vec3d, 8>& x) {
  const Vec3d a = x[1] - x[0], b = x[3] - x[0], c = x[4] - x[0];
  const double scale = norm(a) + norm(b) + norm(c);
  const auto differs = [&](Vec3d corner, Vec3d expected) {
    return norm(corner - x[0] - expected) > 1e-10 * scale;
  };
  return !(differs(x[2], a + b) || differs(x[5], a + c) || differs(x[6], a + b + c) || differs(x[7], b + c));
}

/// The material at a place inside a coarse element.
int material_at(const Body& body, int e, Vec3d x) {
  int material = body.material.empty() ? 0 : body.material[std::size_t(e)];
  for (const Inclusion& sphere : body.inclusions)
    if (norm(x - sphere.centre) <= sphere.radius) material = sphere.material;
  return material;
}

/// Materials of the fine elements: an inclusion is cut out as finely as the patch can.
std::vector<int> fine_materials(const Model& model, const FineMesh& fine) {
  const std::size_t n = std::size_t(model.body.mesh.corners);
  std::vector<int> material(fine.parent.size());
  for (std::size_t f = 0; f < material.size(); f++) {
    Vec3d centre;
    for (std::size_t c = 0; c < n; c++) centre += fine.nodes[std::size_t(fine.corners[n * f + c])].x;
    material[f] = material_at(model.body, fine.parent[f], centre / double(n));
  }
  return material;
}

template <class T>
void add_tets(const Model& model, const FineMesh& fine, const std::vector<int>& material,
              PatchScatter<T>& scatter) {
  std::array<double, 144> k;
  for (std::size_t f = 0; f < fine.parent.size(); f++) {
    tet_stiffness(fine_corners<4>(fine, f), model.body.materials[std::size_t(material[f])], k);
    for (std::size_t a = 0; a < 4; a++)
      for (std::size_t b = 0; b < 4; b++)
        scatter.add(fine.corners[4 * f + a], fine.corners[4 * f + b], &k[36 * a + 3 * b], 12);
  }
}

/// The parts of a parallelepiped are congruent: one stiffness serves all of the same material.
template <class T>
void add_hexes(const Model& model, const FineMesh& fine, const std::vector<int>& material,
               PatchScatter<T>& scatter) {
  std::array<double, 576> k;
  int parent = -1, made_for = -1;
  bool congruent = false;
  for (std::size_t f = 0; f < fine.parent.size(); f++) {
    if (fine.parent[f] != parent) {
      parent = fine.parent[f], made_for = -1;
      congruent = is_parallelepiped(coarse_corners<8>(model.body.mesh, parent));
    }
    if (!congruent || made_for != material[f]) {
      hex_stiffness(fine_corners<8>(fine, f), model.body.materials[std::size_t(material[f])],
                    model.params.formulation, k);
      made_for = material[f];
    }
    for (std::size_t a = 0; a < 8; a++)
      for (std::size_t b = 0; b < 8; b++)
        scatter.add(fine.corners[8 * f + a], fine.corners[8 * f + b], &k[72 * a + 3 * b], 24);
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
    for (std::size_t i = k.row_begin[a]; i < k.row_begin[a + 1]; i++)
      scatter.add(int(a), k.column[i], &k.value[9 * i], 3);
}

/// Adds the stiffness of these coarse elements, as they are among themselves, to the change.
template <class T>
void add_coarse(const Exec& exec, const Model& model, const std::vector<int>& elements, double scale,
                PatchScatter<T>& scatter) {
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
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  for (const int v : vertices) mesh.vertices.push_back(model.body.mesh.vertices[std::size_t(v)]);
  for (const int v : corners)
    mesh.elements.push_back(int(std::lower_bound(vertices.begin(), vertices.end(), v) - vertices.begin()));
  const BlockMatrix k = assemble(exec, mesh, model.body.materials, material, model.params.formulation);
  for (std::size_t a = 0; a < vertices.size(); a++)
    for (std::size_t i = k.row_begin[a]; i < k.row_begin[a + 1]; i++)
      scatter.add_coarse(vertices[a], vertices[std::size_t(k.column[i])], &k.value[9 * i], 3, scale);
}

}  // namespace

bool changes_stiffness(const Model& model, std::span<const int> elements, const FineMesh& fine) {
  if (model.params.formulation == Formulation::kAveraged) return true;
  if (model.body.mesh.corners == 8)
    for (const int e : elements)
      if (!is_parallelepiped(coarse_corners<8>(model.body.mesh, e))) return true;
  if (model.body.inclusions.empty()) return false;
  const std::vector<int> material = fine_materials(model, fine);
  for (std::size_t f = 0; f < material.size(); f++) {
    const int e = fine.parent[f];
    if (material[f] != material_at(model.body, e, centroid(model.body.mesh, std::size_t(e)))) return true;
  }
  return false;
}

std::vector<int> changed_elements(const Model& model, std::span<const int> elements) {
  const SolidMesh& mesh = model.body.mesh;
  std::vector<int> changed(elements.begin(), elements.end());
  if (model.params.formulation == Formulation::kStandard || mesh.corners == 8) return changed;
  std::vector<char> of_patch(mesh.vertices.size(), 0);
  for (const int e : elements)
    for (const int v : element(mesh, std::size_t(e))) of_patch[std::size_t(v)] = 1;
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
  const bool averaged = model.params.formulation == Formulation::kAveraged;
  if (model.body.mesh.corners == 8)
    add_hexes(model, fine, material, scatter);
  else if (averaged)
    add_averaged_tets(alone, model, fine, material, scatter);
  else
    add_tets(model, fine, material, scatter);
  if (with_change) {
    // The coarse stiffness counted the patch's elements; now the fine ones stand for them, and what is left
    // of the coarse ones around the patch is averaged among itself.
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
