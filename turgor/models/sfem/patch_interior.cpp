#include "turgor/models/sfem/patch_interior.hpp"

#include <algorithm>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/sfem/dense_cholesky.hpp"
#include "turgor/models/sfem/elements.hpp"

namespace turgor::sfem {

namespace {

/// Recursive elimination over the coarse elements of a patch.
struct Bisection {
  std::vector<PatchPiece> pieces;  // of each element, until united
  std::vector<Vec3d> centers;      // of each element [m]
  std::vector<int> elements;       // indices of elements, rearranged by bisection
  std::vector<int> remaining;      // number of pieces that contain each function and are not yet united
  std::vector<int> position;       // of each function in the present front
  int first_touched = 0;
  bool is_definite = true;
};

/// A front of the functions to eliminate and of those that remain.
struct PieceFront {
  std::vector<double> panel, rest;
  std::size_t width = 0, height = 0;  // unknowns

  /// First entry of a 3×3 block of the lower half and the distance of its columns.
  std::pair<double*, std::size_t> block(std::size_t row, std::size_t column) {
    const std::size_t all = width + height;
    if (3 * column < width) return {&panel[3 * column * all + 3 * row], all};
    return {&rest[(3 * column - width) * height + 3 * row - width], height};
  }
};

/// Adds the lower half of a piece to a front.
void add_piece(const Bisection& b, const PatchPiece& piece, PieceFront& front) {
  const std::size_t n = piece.functions.size(), stride = 3 * n;
  for (std::size_t c = 0; c < n; c++)
    for (std::size_t r = c; r < n; r++) {
      const auto row = std::size_t(b.position[std::size_t(piece.functions[r])]),
                 column = std::size_t(b.position[std::size_t(piece.functions[c])]);
      const double* from = &piece.values[3 * c * stride + 3 * r];
      const bool swap = row < column;
      const auto [to, rows] = front.block(swap ? column : row, swap ? row : column);
      for (std::size_t j = 0; j < 3; j++)
        for (std::size_t i = 0; i < 3; i++) to[swap ? i * rows + j : j * rows + i] += from[j * stride + i];
    }
}

/// Unites pieces and eliminates the functions below the surface that no other piece contains.
PatchPiece unite(Bisection& b, std::span<const PatchPiece> pieces) {
  // functions to eliminate, then the others
  std::vector<int> functions, eliminated;
  for (const PatchPiece& piece : pieces)
    functions.insert(functions.end(), piece.functions.begin(), piece.functions.end());
  for (const int f : functions) b.remaining[std::size_t(f)]--;
  sort_unique(functions);
  const auto is_complete = [&](int f) { return f < b.first_touched && b.remaining[std::size_t(f)] == 0; };
  std::copy_if(functions.begin(), functions.end(), std::back_inserter(eliminated), is_complete);
  std::erase_if(functions, is_complete);
  for (const int f : functions) b.remaining[std::size_t(f)]++;
  // front
  PieceFront front;
  front.width = 3 * eliminated.size(), front.height = 3 * functions.size();
  front.panel.assign((front.width + front.height) * front.width, 0);
  front.rest.assign(front.height * front.height, 0);
  for (std::size_t i = 0; i < eliminated.size(); i++) b.position[std::size_t(eliminated[i])] = int(i);
  for (std::size_t i = 0; i < functions.size(); i++)
    b.position[std::size_t(functions[i])] = int(eliminated.size() + i);
  for (const PatchPiece& piece : pieces) add_piece(b, piece, front);
  // elimination
  if (front.width > 0 &&
      factor_front(Exec(1), {front.width, front.height, front.panel.data(), front.rest.data()}) >= 0)
    b.is_definite = false;
  return {std::move(functions), std::move(front.rest)};
}

/// Piece of elements [first, last), bisected across their longest extent.
PatchPiece eliminate_range(Bisection& b, std::size_t first, std::size_t last) {
  TURGOR_CHECK(first < last && last <= b.elements.size(), "a range of elements is bisected");
  if (last - first == 1) {
    const PatchPiece own = std::exchange(b.pieces[std::size_t(b.elements[first])], {});
    return unite(b, std::span(&own, 1));
  }
  // longest axis
  const auto center = [&](int e) { return b.centers[std::size_t(e)]; };
  Vec3d low = center(b.elements[first]), high = low;
  for (std::size_t i = first; i < last; i++)
    low = min(low, center(b.elements[i])), high = max(high, center(b.elements[i]));
  const Vec3d extent = high - low;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  // halves
  const auto begin = b.elements.begin() + std::ptrdiff_t(first),
             end = b.elements.begin() + std::ptrdiff_t(last);
  std::sort(begin, end,
            [&](int p, int q) { return std::pair(center(p)[axis], p) < std::pair(center(q)[axis], q); });
  const std::size_t middle = first + (last - first) / 2;
  const PatchPiece halves[] = {eliminate_range(b, first, middle), eliminate_range(b, middle, last)};
  return unite(b, halves);
}

}  // namespace

bool has_free_interior(const Model& model, const PatchUnknowns& unknowns) {
  return unknowns.first_touched > 0 && !averages_nodes(model.body.mesh, model.params.formulation);
}

std::optional<PatchMatrices<double>> without_interior(const Model& model, std::span<const int> elements,
                                                      const FineMesh& fine, const PatchUnknowns& unknowns,
                                                      bool with_change) {
  PatchPieces pieces = assemble_pieces(model, elements, fine, unknowns, with_change);
  TURGOR_CHECK(pieces.of_element.size() == elements.size(), "every element of the patch is a piece");
  // elimination
  const std::size_t coarse = 3 * unknowns.coarse.size(),
                    functions = std::size_t(unknowns.local_count) + unknowns.coarse.size();
  Bisection b;
  b.remaining.assign(functions, 0), b.position.assign(functions, -1);
  b.first_touched = unknowns.first_touched;
  for (const PatchPiece& piece : pieces.of_element)
    for (const int f : piece.functions) b.remaining[std::size_t(f)]++;
  b.pieces = std::move(pieces.of_element);
  for (std::size_t e = 0; e < elements.size(); e++) {
    b.elements.push_back(int(e));
    b.centers.push_back(centroid(model.body.mesh, std::size_t(elements[e])));
  }
  const PatchPiece left = eliminate_range(b, 0, elements.size());
  if (!b.is_definite) return {};
  // matrices of the functions that remain
  const std::size_t touched = 3 * std::size_t(unknowns.local_count - unknowns.first_touched);
  PatchMatrices<double> matrices{std::vector<double>(touched * touched),
                                 std::vector<double>(touched * coarse), std::move(pieces.change)};
  matrices.change.resize(coarse * coarse, 0);
  const std::size_t n = left.functions.size();
  const auto unknown = [&](std::size_t i) {
    return 3 * std::size_t(left.functions[i / 3] - unknowns.first_touched) + i % 3;
  };
  for (std::size_t c = 0; c < 3 * n; c++)
    for (std::size_t r = c; r < 3 * n; r++) {
      const double value = left.values[c * 3 * n + r];
      const std::size_t row = unknown(r), column = unknown(c);
      if (row < touched)
        matrices.local[column * touched + row] = value;
      else if (column < touched)
        matrices.coupling[(row - touched) * touched + column] = value;
      else {
        const std::size_t i = row - touched, j = column - touched;
        matrices.change[j * coarse + i] += value;
        if (i != j) matrices.change[i * coarse + j] += value;
      }
    }
  return matrices;
}

}  // namespace turgor::sfem
