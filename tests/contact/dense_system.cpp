#include "turgor/contact/dense_system.hpp"

#include <Eigen/Dense>
#include <random>

#include <gtest/gtest.h>

#include "turgor/core/aligned.hpp"

namespace turgor::contact {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Solution by solve_in_place; empty if the matrix is called singular.
VectorXd solved(const MatrixXd& a, const VectorXd& b) {
  const auto n = a.rows(), stride = (n + 7) / 8 * 8;
  aligned_vector<double> matrix(std::size_t(stride * n)), rhs(static_cast<std::size_t>(stride)),
      factors(std::size_t(DenseSystem::kPanel * stride), 1e300);
  for (Eigen::Index j = 0; j < n; j++)
    for (Eigen::Index i = 0; i < n; i++) matrix[std::size_t(j * stride + i)] = a(i, j);
  std::copy_n(b.data(), n, rhs.begin());
  if (!solve_in_place({matrix.data(), rhs.data(), factors.data(), int(n), int(stride)})) return {};
  return Eigen::Map<const VectorXd>(rhs.data(), n);
}

// Random systems of all sizes have a small residual, also where the diagonal is zero and rows are exchanged.
TEST(DenseSystem, RandomMatrices_ResidualIsRounding) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const auto number = [&] { return normal(random); };
  double worst = 0;
  for (int n = 1; n <= 70; n++)
    for (const double diagonal : {0.0, 1.0, 30.0}) {
      MatrixXd a = MatrixXd::NullaryExpr(n, n, number);
      for (int i = 0; i < n && n > 1; i++) a(i, i) = diagonal;
      const VectorXd b = VectorXd::NullaryExpr(n, number), x = solved(a, b);
      ASSERT_EQ(x.size(), n) << diagonal;
      worst = std::max(worst, (a * x - b).norm() / (a.norm() * x.norm()));
    }
  EXPECT_LT(worst, 1e-13);
}

// A matrix with two equal rows, and one with an empty column, are reported as singular.
TEST(DenseSystem, SingularMatrixIsReported) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (const int n : {2, 5, 9, 40}) {
    const MatrixXd regular = MatrixXd::NullaryExpr(n, n, [&] { return normal(random); });
    MatrixXd equal = regular, empty = regular;
    equal.row(n - 1) = equal.row(0);
    empty.col(n / 2).setZero();
    EXPECT_EQ(solved(equal, VectorXd::Ones(n)).size(), 0) << n;
    EXPECT_EQ(solved(empty, VectorXd::Ones(n)).size(), 0) << n;
  }
}

}  // namespace
}  // namespace turgor::contact
