#include "turgor/models/sfem/dense_cholesky.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"

namespace turgor::sfem {

namespace {

using Matrix = Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
using Eigen::Index;

#ifdef TURGOR_SAME_BITS
/// Fixes Eigen's block sizes. By default they depend on the processor's caches, and with them the rounding.
[[maybe_unused]] const bool kSameBlocks = (Eigen::setCpuCacheSizes(32 << 10, 1 << 20, 8 << 20), true);
#endif

constexpr Index kBlock = 128;  // columns that are eliminated together
constexpr Index kTile = 192;   // rows or columns that one thread updates

/// Relative size below which a pivot counts as zero: rounding has removed all of its digits, which means a
/// motion without resistance.
constexpr double kLostDigits = 1e-13;

Matrix block(const Matrix& m, Index row, Index column, Index rows, Index columns) {
  double* first = const_cast<double*>(m.data()) + column * m.outerStride() + row;
  return {first, rows, columns, Eigen::OuterStride<>(m.outerStride())};
}

/// A = L Lᵀ in place, column by column; `diagonal` is that of the matrix before anything was eliminated.
int factor_small(Matrix a, const double* diagonal) {
  for (Index j = 0; j < a.cols(); j++) {
    a.col(j).tail(a.rows() - j).noalias() -=
        a.bottomLeftCorner(a.rows() - j, j) * a.row(j).head(j).transpose();
    if (!(a(j, j) > kLostDigits * diagonal[j])) return int(j);
    a.col(j).tail(a.rows() - j) /= std::sqrt(a(j, j));
  }
  return -1;
}

/// The same by halves, so that most of the work is products.
int factor_block(const Matrix& a, const double* diagonal) {
  const Index n = a.cols(), half = n / 2;
  if (n <= 24) return factor_small(a, diagonal);
  const Matrix upper = block(a, 0, 0, half, half);
  Matrix below = block(a, half, 0, n - half, half), rest = block(a, half, half, n - half, n - half);
  if (const int bad = factor_block(upper, diagonal); bad >= 0) return bad;
  upper.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(below);
  rest.selfadjointView<Eigen::Lower>().rankUpdate(below, -1);
  const int bad = factor_block(rest, diagonal + half);
  return bad < 0 ? -1 : int(half) + bad;
}

std::size_t tiles(Index length) { return std::size_t((length + kTile - 1) / kTile); }

/// Calls body(first, count) for every tile of [0, length).
template <class Body>
void for_tiles(const Exec& exec, Index length, const Body& body) {
  parallel_for(exec, tiles(length), [&](std::size_t t) {
    const Index first = Index(t) * kTile;
    body(first, std::min(kTile, length - first));
  });
}

/// The lower half of `rest` loses a bᵀ, where a and b have the same first rows.
void subtract_product(const Exec& exec, Matrix rest, const Matrix& a, const Matrix& b) {
  const std::size_t columns = tiles(rest.cols()), rows = tiles(rest.rows());
  parallel_for(exec, columns * rows, [&](std::size_t t) {
    const Index j = Index(t / rows) * kTile, i = Index(t % rows) * kTile;
    if (i < j) return;
    const Index height = std::min(kTile, rest.rows() - i), width = std::min(kTile, rest.cols() - j);
    Matrix tile = block(rest, i, j, height, width);
    const Matrix left = block(a, i, 0, height, a.cols()), right = block(b, j, 0, width, b.cols());
    if (i == j && height == width)
      tile.triangularView<Eigen::Lower>() -= left * right.transpose();
    else
      tile.noalias() -= left * right.transpose();
  });
}

}  // namespace

int factor_front(const Exec& exec, const Front& front) {
  TURGOR_CHECK(front.panel != nullptr && (front.height == 0 || front.rest != nullptr),
               "a front has both matrices");
  const auto width = Index(front.width), height = Index(front.height), rows = width + height;
  const Matrix panel(front.panel, rows, width, Eigen::OuterStride<>(rows));
  const Eigen::VectorXd diagonal = panel.diagonal();
  for (Index k = 0; k < width; k += kBlock) {
    const Index b = std::min(kBlock, width - k), next = k + b;
    const Matrix pivot = block(panel, k, k, b, b);
    if (const int bad = factor_block(pivot, diagonal.data() + k); bad >= 0) return int(k) + bad;
    for_tiles(exec, rows - next, [&](Index first, Index count) {
      Matrix below = block(panel, next + first, k, count, b);
      pivot.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(below);
    });
    const Matrix below = block(panel, next, k, rows - next, b);
    subtract_product(exec, block(panel, next, next, rows - next, width - next), below, below);
  }
  if (height == 0) return -1;
  const Matrix pivot = block(panel, 0, 0, width, width), below = block(panel, width, 0, height, width);
  subtract_product(exec, {front.rest, height, height, Eigen::OuterStride<>(height)}, below, below);
  for_tiles(exec, height, [&](Index first, Index count) {
    Matrix some = block(below, first, 0, count, width);
    pivot.triangularView<Eigen::Lower>().solveInPlace<Eigen::OnTheRight>(some);
  });
  return -1;
}

}  // namespace turgor::sfem
