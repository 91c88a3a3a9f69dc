#pragma once

#include <array>
#include <vector>

#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/sfem/elements.hpp"
#include "turgor/models/sfem/patch_assembly.hpp"

namespace turgor::sfem {

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

}  // namespace turgor::sfem
