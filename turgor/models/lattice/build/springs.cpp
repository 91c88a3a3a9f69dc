#include "turgor/models/lattice/build/springs.hpp"

#include <Eigen/Dense>
#include <algorithm>

#include "turgor/core/assert.hpp"

namespace turgor::lattice {

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Weights = std::array<double, kFamilyCount>;  // spring stiffness = weight · E · cell volume / length²

Vec3d edge(Vec3d spacing, int family) { return hadamard(spacing, Vec3d(kFamilies[std::size_t(family)])); }

Matrix6 stiffness(Vec3d spacing, const Weights& weights, double volume) {
  Matrix6 c = Matrix6::Zero();
  c.topLeftCorner<3, 3>().setConstant(volume);
  for (int f = 0; f < kFamilyCount; f++) {
    const Vec3d n = normalized(edge(spacing, f));
    Eigen::Matrix<double, 6, 1> nn;
    nn << n.x * n.x, n.y * n.y, n.z * n.z, n.y * n.z, n.x * n.z, n.x * n.y;
    c += weights[std::size_t(f)] * nn * nn.transpose();
  }
  return c;
}

}  // namespace

// Uniaxial tension depends on the compliance matrix, and shear between plates on the stiffness matrix. A
// fixed-point iteration scales six of the seven weights by the square root of their error; the body diagonal
// keeps its weight.
std::array<Real, kFamilyCount> calibrate_springs(Vec3 spacing, double volume) {
  constexpr double kShear = 0.4, kDiagonal = 0.6;
  constexpr std::array<int, 3> kFaceOfShear = {5, 4, 3};  // families in the planes yz, xz, xy
  TURGOR_CHECK(spacing.x > 0 && spacing.y > 0 && spacing.z > 0, "a cell has a volume");
  const Vec3d h(spacing);
  // fixed-point iteration
  Weights weights{1, 1, 1, 1, 1, 1, kDiagonal};
  for (int round = 0; round < 200; round++) {
    const Matrix6 c = stiffness(h, weights, volume), compliance = c.inverse();
    for (int axis = 0; axis < 3; axis++) {
      weights[std::size_t(axis)] *= std::sqrt(compliance(axis, axis));
      weights[std::size_t(kFaceOfShear[std::size_t(axis)])] *= std::sqrt(kShear / c(3 + axis, 3 + axis));
    }
  }
  // stiffness from weights
  std::array<Real, kFamilyCount> scale{};
  for (int f = 0; f < kFamilyCount; f++) {
    const Vec3d e = edge(h, f);
    scale[std::size_t(f)] = Real(weights[std::size_t(f)] * h.x * h.y * h.z / dot(e, e));
  }
  TURGOR_CHECK(std::all_of(scale.begin(), scale.end(), [](Real s) { return s > 0; }),
               "calibrated springs have a positive stiffness");
  return scale;
}

std::array<std::array<double, 6>, 6> homogenized_stiffness(Vec3 spacing,
                                                           const std::array<Real, kFamilyCount>& spring_scale,
                                                           double volume) {
  const Vec3d h(spacing);
  Weights weights{};
  for (int f = 0; f < kFamilyCount; f++) {
    const Vec3d e = edge(h, f);
    weights[std::size_t(f)] = double(spring_scale[std::size_t(f)]) * dot(e, e) / (h.x * h.y * h.z);
  }
  const Matrix6 c = stiffness(h, weights, volume);
  std::array<std::array<double, 6>, 6> rows{};
  for (int row = 0; row < 6; row++)
    for (int column = 0; column < 6; column++) rows[std::size_t(row)][std::size_t(column)] = c(row, column);
  return rows;
}

}  // namespace turgor::lattice
