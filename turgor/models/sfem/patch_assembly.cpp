#include "turgor/models/sfem/patch_assembly.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/quadratic.hpp"
#include "turgor/models/sfem/elements.hpp"

namespace turgor::sfem {

namespace {

/// A column-major matrix of 3×3 blocks, and the sum of other such blocks into it.
template <class T>
struct BlockView {
  std::vector<T>& values;
  std::size_t rows;

  /// `block` row by row with this distance between rows.
  void add(int row, int column, const double* block, std::size_t stride, double scale) const {
    TURGOR_CHECK(row >= 0 && column >= 0 &&
                     is_index((3 * std::size_t(column) + 2) * rows + 3 * std::size_t(row) + 2, values.size()),
                 "the block lies in the matrix");
    T* at = values.data() + 3 * std::size_t(column) * rows + 3 * std::size_t(row);
    for (std::size_t c = 0; c < 3; c++)
      for (std::size_t r = 0; r < 3; r++) at[c * rows + r] += T(scale * block[r * stride + c]);
  }
};

/// The change of the coarse stiffness, Nᵀ K N for all pairs, as far as it is requested.
template <class T>
class ChangeScatter {
 public:
  ChangeScatter(const FineMesh& fine, const PatchUnknowns& unknowns, std::size_t vertices, bool with_change)
      : fine_(fine), unknowns_(unknowns), with_change_(with_change), index_(vertices, -1) {
    for (std::size_t i = 0; i < unknowns.coarse.size(); i++) index_[std::size_t(unknowns.coarse[i])] = int(i);
    const std::size_t coarse = 3 * unknowns.coarse.size();
    if (with_change) change_.assign(coarse * coarse, 0);
  }

  /// The change between two coarse vertices, which may be fixed.
  void add_change(int vertex_row, int vertex_column, const double* block, std::size_t stride, double scale) {
    const int row = coarse_index(vertex_row), column = coarse_index(vertex_column);
    if (row >= 0 && column >= 0)
      BlockView<T>{change_, 3 * unknowns_.coarse.size()}.add(row, column, block, stride, scale);
  }
  /// True when any matrix needs the row of this node.
  bool is_wanted(int a) const { return with_change_ || unknowns_.local[std::size_t(a)] >= 0; }

 protected:
  /// Index of a vertex among the coarse unknowns; -1 = none.
  int coarse_index(int vertex) const { return index_[std::size_t(vertex)]; }
  /// Adds the contribution of node a's row to the change.
  void add_row_to_change(int a, int vertex, const double* block, std::size_t stride, double scale) {
    if (!with_change_) return;
    const FineNode& row = fine_.nodes[std::size_t(a)];
    for (std::size_t s = 0; s < std::size_t(row.supports); s++)
      add_change(row.coarse[s], vertex, block, stride, scale * row.weight[s]);
  }
  std::vector<T> take_change() { return std::move(change_); }

  const FineMesh& fine_;
  const PatchUnknowns& unknowns_;

 private:
  bool with_change_;
  std::vector<int> index_;
  std::vector<T> change_;
};

/// Scatters blocks between fine nodes. u = N u_G + u_L, so a block between nodes a and b contributes to K_L,
/// to K_LG for every coarse support of b, and to the change.
template <class T>
class PatchScatter : public ChangeScatter<T> {
 public:
  PatchScatter(const FineMesh& fine, const PatchUnknowns& unknowns, std::size_t vertices, bool with_change)
      : ChangeScatter<T>(fine, unknowns, vertices, with_change),
        local_rows_(3 * std::size_t(unknowns.local_count)) {
    matrices_.local.assign(local_rows_ * local_rows_, 0);
    matrices_.coupling.assign(local_rows_ * 3 * unknowns.coarse.size(), 0);
  }

  void begin_element(std::size_t) {}
  /// K_L alone: row a, column b.
  void add_local(int a, int b, const double* block, std::size_t stride) {
    const int row = this->unknowns_.local[std::size_t(a)], column = this->unknowns_.local[std::size_t(b)];
    if (column >= 0 && column <= row)
      BlockView<T>{matrices_.local, local_rows_}.add(row, column, block, stride, 1);
  }
  /// Coupling of node a to a coarse vertex: K_LG, and the row's contribution to the change.
  void add_coarse_column(int a, int vertex, const double* block, std::size_t stride, double scale) {
    const int column = this->coarse_index(vertex), local = this->unknowns_.local[std::size_t(a)];
    if (column < 0) return;
    if (local >= 0) BlockView<T>{matrices_.coupling, local_rows_}.add(local, column, block, stride, scale);
    this->add_row_to_change(a, vertex, block, stride, scale);
  }
  PatchMatrices<T> take() {
    matrices_.change = this->take_change();
    return std::move(matrices_);
  }

 private:
  std::size_t local_rows_;
  PatchMatrices<T> matrices_;
};

/// Collects the blocks of one coarse element after the other, each in a small matrix of its own. The change
/// of the coarse stiffness is summed over all of them.
template <std::size_t N>
class PieceScatter : public ChangeScatter<double> {
 public:
  PieceScatter(const SolidMesh& mesh, const FineMesh& fine, const PatchUnknowns& unknowns, bool with_change)
      : ChangeScatter(fine, unknowns, mesh.vertices.size(), with_change),
        mesh_(mesh),
        position_(std::size_t(unknowns.local_count) + unknowns.coarse.size(), -1) {}

  /// Numbers the functions of the coarse element to which fine element `f` belongs.
  void begin_element(std::size_t f) {
    PatchPiece& piece = pieces_.of_element.emplace_back();
    const int parent = fine_.parent[f];
    for (; f < fine_.parent.size() && fine_.parent[f] == parent; f++)
      for (std::size_t c = 0; c < N; c++)
        if (const int own = unknowns_.local[std::size_t(fine_.corners[N * f + c])]; own >= 0)
          piece.functions.push_back(own);
    for (const int v : element(mesh_, std::size_t(parent)))
      if (const int coarse = coarse_index(v); coarse >= 0)
        piece.functions.push_back(unknowns_.local_count + coarse);
    sort_unique(piece.functions);
    for (std::size_t i = 0; i < piece.functions.size(); i++)
      position_[std::size_t(piece.functions[i])] = int(i);
    piece.values.assign(9 * piece.functions.size() * piece.functions.size(), 0);
  }
  void add_local(int a, int b, const double* block, std::size_t stride) {
    const int row = unknowns_.local[std::size_t(a)], column = unknowns_.local[std::size_t(b)];
    if (column >= 0 && column <= row) view().add(at(row), at(column), block, stride, 1);
  }
  void add_coarse_column(int a, int vertex, const double* block, std::size_t stride, double scale) {
    const int column = coarse_index(vertex), local = unknowns_.local[std::size_t(a)];
    if (column < 0) return;
    // K_GL, in the lower half because coarse functions come last
    if (local >= 0) {
      std::array<double, 9> transposed{};
      for (std::size_t i = 0; i < 9; i++) transposed[i] = block[i % 3 * stride + i / 3];
      view().add(at(unknowns_.local_count + column), at(local), transposed.data(), 3, scale);
    }
    add_row_to_change(a, vertex, block, stride, scale);
  }
  PatchPieces take() {
    pieces_.change = take_change();
    return std::move(pieces_);
  }

 private:
  int at(int function) const { return position_[std::size_t(function)]; }
  BlockView<double> view() {
    PatchPiece& piece = pieces_.of_element.back();
    return {piece.values, 3 * piece.functions.size()};
  }

  const SolidMesh& mesh_;
  std::vector<int> position_;  // of each function in the present piece
  PatchPieces pieces_;
};

/// Fine elements of one coarse element. K N, whose columns are the element's corners, is summed for the
/// element before it is scattered to the corners.
template <class Scatter, std::size_t N>
class ElementScatter {
 public:
  ElementScatter(const SolidMesh& mesh, const FineMesh& fine, Scatter& scatter)
      : mesh_(mesh), fine_(fine), scatter_(scatter), local_index_(fine.nodes.size(), -1) {}

  void begin(int e) { element_ = e, nodes_.clear(), rows_.clear(), weights_.clear(); }
  /// One fine element: 3N×3N, row by row.
  void add(const int* nodes, const double* k) {
    // local indices of the nodes
    std::array<int, N> at;
    for (std::size_t c = 0; c < N; c++) at[c] = index_of(nodes[c]);
    for (std::size_t a = 0; a < N; a++) {
      if (!scatter_.is_wanted(nodes[a])) continue;
      auto& row = rows_[std::size_t(at[a])];
      for (std::size_t b = 0; b < N; b++) {
        const double* block = k + 9 * N * a + 3 * b;
        // block of K_L
        scatter_.add_local(nodes[a], nodes[b], block, 3 * N);
        // K N: distribute the block to the corners
        const auto& weight = weights_[std::size_t(at[b])];
        for (std::size_t corner = 0; corner < N; corner++)
          if (weight[corner] != 0)
            for (std::size_t i = 0; i < 9; i++)
              row[9 * corner + i] += weight[corner] * block[i / 3 * 3 * N + i % 3];
      }
    }
  }
  void end() {
    for (std::size_t n = 0; n < nodes_.size(); n++) {
      local_index_[std::size_t(nodes_[n])] = -1;
      if (!scatter_.is_wanted(nodes_[n])) continue;
      for (std::size_t corner = 0; corner < N; corner++)
        scatter_.add_coarse_column(nodes_[n], element(mesh_, std::size_t(element_))[corner],
                                   &rows_[n][9 * corner], 3, 1);
    }
  }

 private:
  int index_of(int node) {
    int& local_index = local_index_[std::size_t(node)];
    if (local_index >= 0) return local_index;
    local_index = int(nodes_.size());
    nodes_.push_back(node);
    rows_.emplace_back();
    std::array<double, N>& weight = weights_.emplace_back();
    const FineNode& from = fine_.nodes[std::size_t(node)];
    for (std::size_t s = 0; s < std::size_t(from.supports); s++)
      for (std::size_t corner = 0; corner < N; corner++)
        if (element(mesh_, std::size_t(element_))[corner] == from.coarse[s]) weight[corner] = from.weight[s];
    return local_index;
  }

  const SolidMesh& mesh_;
  const FineMesh& fine_;
  Scatter& scatter_;
  int element_ = -1;
  std::vector<int> local_index_;                 // of each fine node among those of this element
  std::vector<int> nodes_;                       // of this element
  std::vector<std::array<double, 9 * N>> rows_;  // of each: a block for every corner
  std::vector<std::array<double, N>> weights_;   // of each node on the corners
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
