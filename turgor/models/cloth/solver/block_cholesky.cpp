#include "turgor/models/cloth/solver/block_cholesky.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"

namespace turgor::cloth {

namespace {

/// c −= a bᵀ
void subtract_product(const BlockColumns& a, const BlockColumns& b, BlockColumns& c) {
  for (std::size_t k = 0; k < kRigidModes; k++) {
    BlockColumn sum = c[k];
    for (std::size_t m = 0; m < kRigidModes; m++) sum -= a[m] * b[m][k];
    c[k] = sum;
  }
}

/// a L⁻ᵀ, with the inverse of L.
BlockColumns times_transposed(const BlockColumns& a, const BlockColumns& inverse) {
  BlockColumns product{};
  for (std::size_t k = 0; k < kRigidModes; k++)
    for (std::size_t m = 0; m <= k; m++) product[k] += a[m] * inverse[m][k];
  return product;
}

/// Inverse of the Cholesky factor of a block. Pivots below a fraction of `diagonal` are replaced by it.
BlockColumns inverse_factor(BlockColumns a, const std::array<double, kRigidModes>& diagonal) {
  constexpr double kLeastPivot = 1e-12;
  for (std::size_t k = 0; k < kRigidModes; k++) {
    // column of the factor
    const bool is_positive = a[k][k] > kLeastPivot * diagonal[k];
    const double root = std::sqrt(is_positive ? a[k][k] : diagonal[k]);
    for (std::size_t r = 0; r < kRigidModes; r++) a[k][r] = r < k || !is_positive ? 0 : a[k][r] / root;
    a[k][k] = root;
    // remaining columns
    for (std::size_t m = k + 1; m < kRigidModes; m++) a[m] -= a[k] * a[k][m];
  }
  // inverse by forward substitution
  BlockColumns inverse{};
  for (std::size_t c = 0; c < kRigidModes; c++)
    for (std::size_t r = c; r < kRigidModes; r++) {
      double sum = r == c ? 1 : 0;
      for (std::size_t k = c; k < r; k++) sum -= a[k][r] * inverse[c][k];
      inverse[c][r] = sum / a[r][r];
    }
  return inverse;
}

BlockColumns columns_of(const Block& rows) {
  BlockColumns columns{};
  for (std::size_t r = 0; r < kRigidModes; r++)
    for (std::size_t c = 0; c < kRigidModes; c++) columns[c][r] = rows[r * kRigidModes + c];
  return columns;
}

/// Subtracts the products of a finished column from the columns to its right.
void update_right(std::size_t column, std::vector<BlockColumns>& diagonal, BlockCholesky& factor) {
  const int first = factor.begin[column], last = factor.begin[column + 1];
  for (int n = first; n < last; n++) {
    const auto target = std::size_t(factor.row[std::size_t(n)]);
    const BlockColumns& own = factor.below[std::size_t(n)];
    subtract_product(own, own, diagonal[target]);
    // the rows below are among those of the target
    auto at = std::size_t(factor.begin[target]);
    for (int m = n + 1; m < last; m++, at++) {
      while (factor.row[at] != factor.row[std::size_t(m)]) at++;
      subtract_product(factor.below[std::size_t(m)], own, factor.below[at]);
    }
  }
}

}  // namespace

std::vector<int> elimination_order(std::vector<std::vector<int>> neighbors) {
  std::vector<int> order;
  std::vector<char> is_done(neighbors.size(), 0);
  while (order.size() < neighbors.size()) {
    // block with the fewest neighbors
    std::size_t next = neighbors.size();
    for (std::size_t b = 0; b < neighbors.size(); b++)
      if (is_done[b] == 0 && (next == neighbors.size() || neighbors[b].size() < neighbors[next].size()))
        next = b;
    order.push_back(int(next)), is_done[next] = 1;
    // its neighbors become neighbors of each other
    const std::vector<int> clique = std::move(neighbors[next]);
    for (const int b : clique) {
      std::vector<int>& list = neighbors[std::size_t(b)];
      list.insert(list.end(), clique.begin(), clique.end());
      sort_unique(list);
      std::erase_if(list, [&](int other) { return other == b || other == int(next); });
    }
  }
  return order;
}

void analyze(std::span<const int> pair_begin, std::span<const int> pair, BlockCholesky& factor) {
  const std::size_t count = pair_begin.size() - 1;
  std::vector<std::vector<int>> rows(count);
  for (std::size_t a = 0; a < count; a++)
    for (int n = pair_begin[a]; n + 1 < pair_begin[a + 1]; n++)
      rows[std::size_t(pair[std::size_t(n)])].push_back(int(a));
  // the rows of a column are also those of its first row's column
  factor.begin.assign(1, 0), factor.row.clear();
  for (std::vector<int>& list : rows) {
    sort_unique(list);
    if (!list.empty()) {
      std::vector<int>& next = rows[std::size_t(list[0])];
      next.insert(next.end(), list.begin() + 1, list.end());
    }
    factor.row.insert(factor.row.end(), list.begin(), list.end());
    factor.begin.push_back(int(factor.row.size()));
  }
  factor.below.resize(factor.row.size()), factor.inverse.resize(count), factor.right_side.resize(count);
  TURGOR_CHECK(all_indices(factor.row, count), "the rows of a factor are blocks");
}

void factorize(std::span<const int> pair_begin, std::span<const int> pair, std::span<const Block> matrix,
               BlockCholesky& factor) {
  const std::size_t count = factor.inverse.size();
  TURGOR_CHECK(pair_begin.size() == count + 1 && matrix.size() == pair.size(),
               "the factor was analyzed for this matrix");
  // entries of the matrix; the diagonal blocks are in `inverse` until their turn
  std::fill(factor.below.begin(), factor.below.end(), BlockColumns{});
  for (std::size_t a = 0; a < count; a++) {
    const int last = pair_begin[a + 1] - 1;
    factor.inverse[a] = columns_of(matrix[std::size_t(last)]);
    for (int n = pair_begin[a]; n < last; n++) {
      const auto column = std::size_t(pair[std::size_t(n)]);
      const auto rows = factor.row.begin();
      const auto at =
          std::lower_bound(rows + factor.begin[column], rows + factor.begin[column + 1], int(a)) - rows;
      factor.below[std::size_t(at)] = columns_of(matrix[std::size_t(n)]);
    }
  }
  // columns from left to right
  for (std::size_t j = 0; j < count; j++) {
    const Block& own = matrix[std::size_t(pair_begin[j + 1]) - 1];
    std::array<double, kRigidModes> diagonal;
    for (std::size_t k = 0; k < kRigidModes; k++) diagonal[k] = own[k * (kRigidModes + 1)];
    factor.inverse[j] = inverse_factor(factor.inverse[j], diagonal);
    for (int n = factor.begin[j]; n < factor.begin[j + 1]; n++)
      factor.below[std::size_t(n)] = times_transposed(factor.below[std::size_t(n)], factor.inverse[j]);
    update_right(j, factor.inverse, factor);
  }
}

void solve(BlockCholesky& factor) {
  const std::size_t count = factor.inverse.size();
  std::vector<BlockColumn>& x = factor.right_side;
  TURGOR_CHECK(x.size() == count, "every block has a right-hand side");
  // L y = b
  for (std::size_t j = 0; j < count; j++) {
    BlockColumn y{};
    for (std::size_t k = 0; k < kRigidModes; k++) y += factor.inverse[j][k] * x[j][k];
    x[j] = y;
    for (int n = factor.begin[j]; n < factor.begin[j + 1]; n++) {
      BlockColumn& other = x[std::size_t(factor.row[std::size_t(n)])];
      for (std::size_t k = 0; k < kRigidModes; k++) other -= factor.below[std::size_t(n)][k] * y[k];
    }
  }
  // Lᵀ x = y
  const auto sum_of = [](BlockColumn a) { return ((a[0] + a[1]) + (a[2] + a[3])) + (a[4] + a[5]); };
  for (std::size_t j = count; j-- > 0;) {
    BlockColumns sums{};
    for (int n = factor.begin[j]; n < factor.begin[j + 1]; n++)
      for (std::size_t k = 0; k < kRigidModes; k++)
        sums[k] += factor.below[std::size_t(n)][k] * x[std::size_t(factor.row[std::size_t(n)])];
    BlockColumn rest = x[j];
    for (std::size_t k = 0; k < kRigidModes; k++) rest[k] -= sum_of(sums[k]);
    BlockColumn result{};
    for (std::size_t k = 0; k < kRigidModes; k++) result[k] = sum_of(factor.inverse[j][k] * rest);
    x[j] = result;
  }
}

}  // namespace turgor::cloth
