// Sparse Cholesky factor L Lᵀ of a symmetric matrix of 6×6 blocks, for the coarse system of two_level.hpp.
// Blocks are eliminated in their given order, which should keep the fill small (elimination_order).
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "turgor/core/lanes.hpp"

namespace turgor::cloth {

constexpr int kRigidModes = 6;  // rigid modes of a block: three translations, three rotations

using Block = std::array<double, kRigidModes * kRigidModes>;  // by rows

/// A column of a block; the last two of its eight numbers are 0.
using BlockColumn = double __attribute__((vector_size(64)));
using BlockColumns = std::array<BlockColumn, kRigidModes>;

/// Factor of a matrix. Entries of L are stored by column, the diagonal block as its inverse.
struct BlockCholesky {
  std::vector<int> begin, row;          // rows below the diagonal of each column, ascending
  std::vector<BlockColumns> below;      // L_ij of each of these rows
  std::vector<BlockColumns> inverse;    // L_jj⁻¹ of each column
  std::vector<BlockColumn> right_side;  // of a solution; the result is in its position
};

/// Order of elimination with small fill: a block with the fewest neighbors comes first [minimum degree: Rose
/// 1972]. `neighbors` are symmetric, without the block itself.
std::vector<int> elimination_order(std::vector<std::vector<int>> neighbors);

/// Finds the rows of the factor. The matrix has the blocks (a, pair[n]), n = pair_begin[a] …
/// pair_begin[a + 1] − 1, of which the last is (a, a) and the others are below the diagonal, ascending.
void analyze(std::span<const int> pair_begin, std::span<const int> pair, BlockCholesky& factor);

/// Factors the matrix with these blocks, in the order of `pair`. A pivot that is not positive, from rounding,
/// is replaced by the diagonal of the matrix, so the factor is always that of a positive matrix.
void factorize(std::span<const int> pair_begin, std::span<const int> pair, std::span<const Block> matrix,
               BlockCholesky& factor);

/// Solves L Lᵀ x = right_side in its position.
void solve(BlockCholesky& factor);

}  // namespace turgor::cloth
