#include "turgor/models/lattice/coarse/block_moments.hpp"

#include "turgor/core/assert.hpp"

namespace turgor::lattice {

namespace {

/// Quadratic Lagrange polynomials of the nodes 0, 1/2 and 1.
std::array<double, 3> lagrange(double t) { return {(2 * t - 1) * (t - 1), 4 * t * (1 - t), t * (2 * t - 1)}; }

/// Position m of the 27, x fastest.
Vec3d sample_position(std::size_t m) { return Vec3d{double(m % 3), double(m / 3 % 3), double(m / 9)} * 0.5; }

/// Trilinear weights of the corners of a block at a position, also outside of it.
std::array<double, 8> weights_at(Vec3d t) {
  std::array<double, 8> weights;
  for (int c = 0; c < 8; c++)
    weights[std::size_t(c)] = (c & 1 ? t.x : 1 - t.x) * (c & 2 ? t.y : 1 - t.y) * (c & 4 ? t.z : 1 - t.z);
  return weights;
}

}  // namespace

std::array<Mat3d, 64> cell_stiffness(Vec3 spacing, double poisson) {
  TURGOR_CHECK(poisson >= 0 && poisson < 0.5, "Poisson's ratio is from 0 to below 0.5");
  // Lame parameters for a Young's modulus of 1
  const Vec3d h(spacing);
  const double volume = h.x * h.y * h.z, mu = 0.5 / (1 + poisson),
               lambda = poisson / ((1 + poisson) * (1 - 2 * poisson)),
               hourglass = double(solid_law(spacing, poisson).hourglass);
  std::array<Mat3d, 64> k{};
  // blocks of all corner pairs
  for (int a = 0; a < 8; a++)
    for (int b = 0; b < 8; b++) {
      // shape function gradients at the cell center
      const Vec3d sa(corner_sign(a)), sb(corner_sign(b));
      const Vec3d ga = Vec3d{sa.x / h.x, sa.y / h.y, sa.z / h.z} * 0.25,
                  gb = Vec3d{sb.x / h.x, sb.y / h.y, sb.z / h.z} * 0.25;
      // diagonal share: shear and hourglass stiffness
      const double alike = volume * mu * dot(ga, gb) + hourglass * ((a == b ? 1 : 0) - (1 + dot(sa, sb)) / 8);
      // add the elastic block
      Mat3d& m = k[std::size_t(8 * a + b)];
      for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
          m.column[std::size_t(j)][i] =
              volume * (mu * gb[i] * ga[j] + lambda * ga[i] * gb[j]) + (i == j ? alike : 0);
    }
  return k;
}

void add_moments(Vec3d position, double value, Moments& moments) {
  const std::array<double, 3> x = lagrange(position.x), y = lagrange(position.y), z = lagrange(position.z);
  for (std::size_t k = 0; k < 3; k++)
    for (std::size_t j = 0; j < 3; j++)
      for (std::size_t i = 0; i < 3; i++) moments[9 * k + 3 * j + i] += value * z[k] * y[j] * x[i];
}

BlockBasis block_basis(int size, Vec3 spacing, double poisson) {
  TURGOR_CHECK(size > 0, "a block has cells");
  const std::array<Mat3d, 64> k = cell_stiffness(spacing, poisson);
  BlockBasis basis{};
  for (std::size_t m = 0; m < kMoments; m++) {
    // cell with its lowest node at the position
    NodeWeights weights;
    for (int n = 0; n < kCellCorners; n++)
      weights[std::size_t(n)] = weights_at(sample_position(m) + Vec3d(cell_corner(n)) * (1.0 / size));
    const auto of_pair = [&](int p, int q) -> const Mat3d& { return k[std::size_t(8 * p + q)]; };
    add_projected(kCellCorners, weights, of_pair, 1, basis.stiffness[m]);
    // node at the position
    const std::array<double, 8> w = weights_at(sample_position(m));
    for (std::size_t p = 0; p < 8; p++)
      for (std::size_t q = 0; q < 8; q++) basis.inertia[m][8 * p + q] = w[p] * w[q];
  }
  return basis;
}

void add_expanded(const BlockMoments& moments, const BlockBasis& basis, BlockMatrix& sum) {
  // stiffness
  for (std::size_t m = 0; m < kMoments; m++) {
    const double by = moments.stiffness[m];
    if (by == 0) continue;
    for (std::size_t n = 0; n < sum.size(); n++) sum[n] += by * basis.stiffness[m][n];
  }
  // inertia, equal for the three components
  std::array<double, 64> inertia{};
  for (std::size_t m = 0; m < kMoments; m++)
    for (std::size_t n = 0; n < 64; n++) inertia[n] += moments.inertia[m] * basis.inertia[m][n];
  for (std::size_t p = 0; p < 8; p++)
    for (std::size_t i = 0; i < 3; i++)
      for (std::size_t q = 0; q < 8; q++) sum[(3 * p + i) * kBlockNumbers + 8 * i + q] += inertia[8 * p + q];
}

}  // namespace turgor::lattice
