// Projection of elements to the corners of a block in the coarse space. The weights of the corners at a node
// are linear in each coordinate of the node. So the projected stiffness of a cell, Wᵀ k W, is quadratic in
// each coordinate r of the cell, and Lagrange interpolation between 27 positions r_m in the block is exact:
//   Σ E W(r)ᵀ k W(r) = Σ_m (Σ E L_m(r)) W(r_m)ᵀ k W(r_m)
// A cell is added to 27 moments Σ E L_m(r) of its block instead of a matrix of 24 × 24. The same holds for
// the inertia of nodes.
#pragma once

#include <array>
#include <cstddef>

#include "turgor/core/vec.hpp"
#include "turgor/models/lattice/mechanics/solid.hpp"

namespace turgor::lattice {

constexpr std::size_t kBlockNumbers = 24;  // degrees of freedom of a block
/// Entry (3 p + i) · 24 + 8 j + q couples component i of corner p with component j of corner q [N/m].
using BlockMatrix = std::array<double, kBlockNumbers * kBlockNumbers>;
/// Weights of the eight corners of a block at up to eight nodes.
using NodeWeights = std::array<std::array<double, 8>, kCellCorners>;

/// Adds `scale` Wᵀ k W to the matrix of a block. `of_pair(a, b)`: stiffness of a pair of nodes [N/m]. Fixed
/// nodes have no weights.
template <class OfPair>
void add_projected(std::size_t nodes, const NodeWeights& weights, const OfPair& of_pair, double scale,
                   BlockMatrix& sum) {
  constexpr std::array<double, 8> kFixed{};
  for (std::size_t a = 0; a < nodes; a++) {
    if (weights[a] == kFixed) continue;
    // k W of one node
    double by_corner[3][kBlockNumbers] = {};
    for (std::size_t b = 0; b < nodes; b++) {
      if (weights[b] == kFixed) continue;
      const Mat3d& k = of_pair(int(a), int(b));
      for (int i = 0; i < 3; i++)
        for (std::size_t j = 0; j < 3; j++)
          for (std::size_t q = 0; q < 8; q++) by_corner[i][8 * j + q] += weights[b][q] * k.column[j][i];
    }
    // its share of Wᵀ k W
    for (std::size_t p = 0; p < 8; p++) {
      const double w = scale * weights[a][p];
      if (w == 0) continue;
      for (std::size_t i = 0; i < 3; i++)
        for (std::size_t n = 0; n < kBlockNumbers; n++)
          sum[(3 * p + i) * kBlockNumbers + n] += w * by_corner[i][n];
    }
  }
}

/// Stiffness of pairs of corners 8 a + b of a cell with E = 1: linear elasticity at the center and the
/// hourglass stiffness.
///   k_ab = V (µ g_b g_aᵀ + λ g_a g_bᵀ + µ (g_a · g_b) I) + V κ/8 (δ_ab − (1 + s_a · s_b)/8) I
/// g: gradient of the shape function, s: signs of the corner. This is the Hessian of add_cell at rest.
std::array<Mat3d, 64> cell_stiffness(Vec3 spacing, double poisson);

constexpr std::size_t kMoments = 27;
using Moments = std::array<double, kMoments>;
struct BlockMoments {
  Moments stiffness{};  // of cells, by their lowest nodes [Pa]
  Moments inertia{};    // of nodes [N/m]
};
/// Adds a value at a position in a block, 0 to 1.
void add_moments(Vec3d position, double value, Moments& moments);

/// Projections at the 27 positions.
struct BlockBasis {
  std::array<BlockMatrix, kMoments> stiffness;           // of a cell with E = 1 [m]
  std::array<std::array<double, 64>, kMoments> inertia;  // of a node, by pair of corners 8 p + q [1]
};
/// Basis of blocks with this many cells per side.
BlockBasis block_basis(int size, Vec3 spacing, double poisson);
/// Adds the stiffness and inertia that the moments stand for.
void add_expanded(const BlockMoments& moments, const BlockBasis& basis, BlockMatrix& sum);

}  // namespace turgor::lattice
