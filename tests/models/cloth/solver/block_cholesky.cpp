#include "turgor/models/cloth/solver/block_cholesky.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "tests/models/cloth/storm.hpp"

namespace turgor::cloth {
namespace {

/// Matrix with 2 a aᵀ on the diagonals of a pair and a aᵀ between, for each pair of neighbors in a square
/// grid.
struct GridMatrix {
  std::vector<int> pair_begin{0}, pair;
  std::vector<Block> blocks;
};
GridMatrix grid_matrix(int side, double diagonal) {
  GridMatrix grid;
  RandomNumbers next{3};
  for (int a = 0; a < side * side; a++) {
    if (a >= side) grid.pair.push_back(a - side);
    if (a % side > 0) grid.pair.push_back(a - 1);
    grid.pair.push_back(a);
    grid.pair_begin.push_back(int(grid.pair.size()));
  }
  grid.blocks.resize(grid.pair.size());
  for (int a = 0; a < side * side; a++) {
    Block& own = grid.blocks[std::size_t(grid.pair_begin[std::size_t(a) + 1]) - 1];
    for (std::size_t k = 0; k < kRigidModes; k++) own[7 * k] += diagonal;
    for (int n = grid.pair_begin[std::size_t(a)]; n + 1 < grid.pair_begin[std::size_t(a) + 1]; n++) {
      const auto b = std::size_t(grid.pair[std::size_t(n)]);
      Block& other = grid.blocks[std::size_t(grid.pair_begin[b + 1]) - 1];
      double v[kRigidModes], w[kRigidModes];
      for (int k = 0; k < kRigidModes; k++) v[k] = next(), w[k] = next();
      for (std::size_t r = 0; r < kRigidModes; r++)
        for (std::size_t c = 0; c < kRigidModes; c++) {
          own[r * kRigidModes + c] += v[r] * v[c], other[r * kRigidModes + c] += w[r] * w[c];
          grid.blocks[std::size_t(n)][r * kRigidModes + c] += v[r] * w[c];
        }
    }
  }
  return grid;
}

/// Matrix times x.
std::vector<BlockColumn> product(const GridMatrix& grid, const std::vector<BlockColumn>& x) {
  std::vector<BlockColumn> sum(x.size(), BlockColumn{});
  for (std::size_t a = 0; a < x.size(); a++)
    for (int n = grid.pair_begin[a]; n < grid.pair_begin[a + 1]; n++) {
      const auto b = std::size_t(grid.pair[std::size_t(n)]);
      const Block& block = grid.blocks[std::size_t(n)];
      for (std::size_t r = 0; r < kRigidModes; r++)
        for (std::size_t c = 0; c < kRigidModes; c++) {
          sum[a][r] += block[r * kRigidModes + c] * x[b][c];
          if (b != a) sum[b][c] += block[r * kRigidModes + c] * x[a][r];
        }
    }
  return sum;
}

double largest_difference(const std::vector<BlockColumn>& a, const std::vector<BlockColumn>& b) {
  double largest = 0;
  for (std::size_t n = 0; n < a.size(); n++)
    for (std::size_t k = 0; k < kRigidModes; k++) largest = std::max(largest, std::abs(a[n][k] - b[n][k]));
  return largest;
}

// A solution times the matrix is the right-hand side.
TEST(ClothBlockCholesky, SolvesSparseSystems) {
  for (const int side : {1, 2, 7, 12}) {
    const GridMatrix grid = grid_matrix(side, 0.3);
    BlockCholesky factor;
    analyze(grid.pair_begin, grid.pair, factor);
    factorize(grid.pair_begin, grid.pair, grid.blocks, factor);
    RandomNumbers next{9};
    for (BlockColumn& b : factor.right_side)
      for (std::size_t k = 0; k < kRigidModes; k++) b[k] = next();
    const std::vector<BlockColumn> wanted = factor.right_side;
    solve(factor);
    EXPECT_LT(largest_difference(product(grid, factor.right_side), wanted), 1e-10) << side;
  }
}

// A singular matrix gives a finite solution that does not oppose the right-hand side.
TEST(ClothBlockCholesky, SingularMatrixStaysPositive) {
  const GridMatrix grid = grid_matrix(3, 0);
  GridMatrix empty = grid;
  for (Block& block : empty.blocks) block.fill(0);
  for (std::size_t a = 0; a < 9; a++)
    for (std::size_t k = 0; k < kRigidModes; k++)
      empty.blocks[std::size_t(empty.pair_begin[a + 1]) - 1][7 * k] = k < 3 ? 1 : 1e-30;
  for (const GridMatrix* matrix : {&grid, static_cast<const GridMatrix*>(&empty)}) {
    BlockCholesky factor;
    analyze(matrix->pair_begin, matrix->pair, factor);
    factorize(matrix->pair_begin, matrix->pair, matrix->blocks, factor);
    for (BlockColumn& b : factor.right_side) b = BlockColumn{1, -1, 2, 0, 1, 1};
    const std::vector<BlockColumn> load = factor.right_side;
    solve(factor);
    double work = 0;
    for (std::size_t n = 0; n < load.size(); n++)
      for (std::size_t k = 0; k < kRigidModes; k++) work += load[n][k] * factor.right_side[n][k];
    EXPECT_TRUE(std::isfinite(work));
    EXPECT_GT(work, 0);
  }
}

// Minimum degree needs less than half of the fill of a grid row by row.
TEST(ClothBlockCholesky, EliminationOrderReducesFill) {
  constexpr int kSide = 16, kCount = kSide * kSide;
  std::vector<std::vector<int>> neighbors(kCount);
  for (int a = 0; a < kCount; a++)
    for (const int b : {a - kSide, a % kSide > 0 ? a - 1 : -1, a % kSide < kSide - 1 ? a + 1 : -1, a + kSide})
      if (b >= 0 && b < kCount) neighbors[std::size_t(a)].push_back(b);
  const auto fill = [&](const std::vector<int>& order) {
    std::vector<int> position(kCount), pair_begin{0}, pair;
    for (int n = 0; n < kCount; n++) position[std::size_t(order[std::size_t(n)])] = n;
    for (const int a : order) {
      std::vector<int> before;
      for (const int b : neighbors[std::size_t(a)]) before.push_back(position[std::size_t(b)]);
      std::sort(before.begin(), before.end());
      for (const int b : before)
        if (b < position[std::size_t(a)]) pair.push_back(b);
      pair.push_back(position[std::size_t(a)]);
      pair_begin.push_back(int(pair.size()));
    }
    BlockCholesky factor;
    analyze(pair_begin, pair, factor);
    return factor.row.size();
  };
  std::vector<int> in_rows(kCount), order = elimination_order(neighbors);
  std::iota(in_rows.begin(), in_rows.end(), 0);
  ASSERT_TRUE(std::is_permutation(order.begin(), order.end(), in_rows.begin()));
  EXPECT_LT(2 * fill(order), fill(in_rows));
}

}  // namespace
}  // namespace turgor::cloth
