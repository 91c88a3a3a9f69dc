#include "turgor/models/sfem/cholesky.hpp"

#include <Eigen/Dense>
#include <numeric>
#include <thread>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <gtest/gtest.h>

#include "tests/models/sfem/dense.hpp"
#include "turgor/models/sfem/dissection.hpp"

namespace turgor::sfem {
namespace {

constexpr Vec3d kSize{0.12, 0.1, 0.08};

/// About 500 free nodes, distorted, two materials.
Model body(int corners, Formulation formulation, Int3 cells = {9, 7, 6}) {
  SolidMesh mesh = hex_block(kSize, cells);
  distort(mesh, kSize, 0.0015);
  mesh = with_corners(mesh, corners);
  Body result = block_of(std::move(mesh), {3e3, 0.45}, [](Vec3d x) { return x.z < 1e-9; });
  result.materials.push_back({3e4, 0.3});
  result.inclusions = {{{0.06, 0.05, 0.04}, 0.02, 1}};
  return build(Exec(1), std::move(result), {.formulation = formulation}).value();
}

Elimination plan(const Model& model) {
  return plan_elimination(model.stiffness, nested_dissection(model.stiffness));
}

Eigen::VectorXd loads(Eigen::Index n) {
  Eigen::VectorXd f(n);
  for (Eigen::Index i = 0; i < n; i++) f[i] = std::sin(1.3 * double(i * i % 1001));
  return f;
}

// A plan eliminates every row once, and the rows of a supernode follow it.
TEST(SfemCholesky, PlanEliminatesEveryRowOnce) {
  const Model model = body(8, Formulation::kStandard);
  const Elimination p = plan(model);
  std::vector<int> sorted = p.order;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 0; i < sorted.size(); i++) EXPECT_EQ(sorted[i], int(i));
  int next = 0;
  for (std::size_t n = 0; n < p.supernodes.size(); n++) {
    const Supernode& s = p.supernodes[n];
    EXPECT_EQ(s.first, next);
    next += s.count;
    if (s.row_count > 0) {
      EXPECT_GE(rows_of(p, s)[0], next);
    }
    EXPECT_TRUE(s.parent < 0 || s.parent > int(n));
  }
  EXPECT_EQ(next, int(p.order.size()));
}

// Nested dissection needs less than half the work of the natural order.
TEST(SfemCholesky, NestedDissectionHalvesWork) {
  const Model model = body(8, Formulation::kStandard, {18, 18, 18});
  std::vector<int> numbering(model.vertex.size());
  std::iota(numbering.begin(), numbering.end(), 0);
  EXPECT_LT(plan(model).flops, 0.5 * plan_elimination(model.stiffness, numbering).flops);
}

// Nested dissection gives the same order in concurrent threads.
TEST(SfemCholesky, NestedDissectionIsThreadSafe) {
  const Model model = body(4, Formulation::kStandard, {12, 12, 12});
  const std::vector<int> expected = nested_dissection(model.stiffness);
  std::vector<std::vector<int>> found(4);
  std::vector<std::thread> threads;
  for (std::vector<int>& order : found)
    threads.emplace_back([&] { order = nested_dissection(model.stiffness); });
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<int>& order : found) EXPECT_EQ(order, expected);
}

// Disconnected rows are ordered too.
TEST(SfemCholesky, OrdersDisconnectedRows) {
  BlockMatrix k;
  k.row_begin = {0, 1, 2, 3};
  k.column = {0, 1, 2};
  EXPECT_EQ(nested_dissection(k), (std::vector<int>{0, 1, 2}));
  k.row_begin = {0, 2, 4, 5};  // 0 and 1 are connected, 2 is separate
  k.column = {0, 1, 0, 1, 2};
  std::vector<int> order = nested_dissection(k);
  std::sort(order.begin(), order.end());
  EXPECT_EQ(order, (std::vector<int>{0, 1, 2}));
}

// Solutions match those of a dense factor, for one and for many right-hand sides.
TEST(SfemCholesky, SolutionsMatchDenseFactor) {
  for (const int corners : {4, 8})
    for (const Formulation formulation : {Formulation::kStandard, Formulation::kAveraged}) {
      const Model model = body(corners, formulation);
      const Cholesky factor = factorize(Exec(2), model.stiffness, plan(model), model.vertex).value();
      const Eigen::MatrixXd k = dense(model.stiffness);
      const Eigen::VectorXd f = loads(k.rows()), expected = k.llt().solve(f);
      Eigen::VectorXd one = f;
      solve(factor, std::span(one.data(), std::size_t(one.size())));
      EXPECT_LT((one - expected).norm(), 1e-12 * expected.norm()) << corners << " corners";
      Eigen::MatrixXd many = f * Eigen::RowVectorXd::LinSpaced(70, 1, 70);
      solve(Exec(2), factor, std::span(many.data(), std::size_t(many.size())));
      EXPECT_LT((many.col(66) - 67 * expected).norm(), 1e-12 * 67 * expected.norm());
    }
}

// Solutions of a larger body, whose dense factor would take half a minute, leave no residual.
TEST(SfemCholesky, SolutionsOfLargerBodyLeaveNoResidual) {
  for (const Formulation formulation : {Formulation::kStandard, Formulation::kAveraged}) {
    const Model model = body(10, formulation);
    const Cholesky factor = factorize(Exec(2), model.stiffness, plan(model), model.vertex).value();
    const Eigen::MatrixXd k = dense(model.stiffness);
    const Eigen::VectorXd f = loads(k.rows());
    Eigen::MatrixXd many = f * Eigen::RowVectorXd::LinSpaced(70, 1, 70);
    solve(Exec(2), factor, std::span(many.data(), std::size_t(many.size())));
    Eigen::VectorXd one = f;
    solve(factor, std::span(one.data(), std::size_t(one.size())));
    const double largest = k.cwiseAbs().rowwise().sum().maxCoeff();
    EXPECT_LT((k * one - f).norm(), 1e-14 * largest * one.norm());
    EXPECT_LT((many.col(66) - 67 * one).norm(), 1e-12 * 67 * one.norm());
  }
}

// Solutions for unit forces are columns of the inverse at the requested rows.
TEST(SfemCholesky, UnitSolutionsMatchInverse) {
  const Model model = body(8, Formulation::kStandard);
  const Cholesky factor = factorize(Exec(1), model.stiffness, plan(model), model.vertex).value();
  const Eigen::MatrixXd inverse = dense(model.stiffness).inverse();
  const std::vector<int> units{3, 200, 17}, rows{5, 100, 250, 400};
  UnitSolutions solutions;
  solve_units(factor, units, with_ancestors(factor.plan, rows), 0, solutions);
  ASSERT_EQ(solutions.columns, 9u);
  for (const int row : rows)
    for (int i = 0; i < 3; i++)
      for (int c = 0; c < 9; c++) {
        const double found = solutions.row(factor.plan.position[std::size_t(row)])[i * 9 + c];
        EXPECT_NEAR(found, inverse(3 * row + i, 3 * units[std::size_t(c / 3)] + c % 3),
                    1e-12 * inverse.cwiseAbs().maxCoeff());
      }
}

#ifdef __GLIBC__
std::size_t bytes_in_use() {
  const auto info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

// While factoring, the contributions of supernodes are released as soon as their parents have taken them.
TEST(SfemCholesky, ContributionsAreReleased) {
  const Model model = body(8, Formulation::kStandard, {14, 14, 14});
  const Elimination p = plan(model);
  const std::size_t before = bytes_in_use(), factor = sizeof(double) * p.value_count,
                    work = sizeof(double) * p.work_count;
  std::size_t peak = 0;
  const auto sample = [&](double) { peak = std::max(peak, bytes_in_use()); };
  ASSERT_TRUE(factorize(Exec(1), model.stiffness, p, model.vertex, sample));
  std::printf("factor %zu MB, work %zu MB, peak %zu MB\n", factor >> 20, work >> 20, (peak - before) >> 20);
  EXPECT_LT(peak, before + factor + 3 * work);
}
#endif

// One, two and eight threads give the same bits.
TEST(SfemCholesky, EqualBitsOnAnyThreads) {
  const Model model = body(8, Formulation::kStandard, {12, 12, 12});
  const Cholesky one = factorize(Exec(1), model.stiffness, plan(model), model.vertex).value();
  for (const int threads : {2, 8})
    EXPECT_EQ(one.values, factorize(Exec(threads), model.stiffness, plan(model), model.vertex)->values);
}

// A large system with wide supernodes is solved up to rounding.
TEST(SfemCholesky, WideSupernodesAreSolvedToRounding) {
  const Model model = body(8, Formulation::kStandard, {14, 14, 14});
  const Cholesky factor = factorize(Exec(2), model.stiffness, plan(model), model.vertex).value();
  int widest = 0;
  for (const Supernode& s : factor.plan.supernodes) widest = std::max(widest, 3 * s.count);
  EXPECT_GT(widest, 256);  // several blocks and tiles of the dense kernels
  const Eigen::VectorXd f = loads(3 * Eigen::Index(model.vertex.size()));
  Eigen::VectorXd u = f, back = Eigen::VectorXd::Zero(f.size());
  solve(factor, std::span(u.data(), std::size_t(u.size())));
  const BlockMatrix& k = model.stiffness;
  for (std::size_t row = 0; row < model.vertex.size(); row++)
    for (std::size_t b = k.row_begin[row]; b < k.row_begin[row + 1]; b++)
      for (std::size_t i = 0; i < 9; i++)
        back[Eigen::Index(3 * row + i / 3)] += k.value[9 * b + i] * u[3 * k.column[b] + Eigen::Index(i % 3)];
  EXPECT_LT((back - f).norm(), 1e-12 * f.norm());
}

// The error for a singular matrix names the vertex.
TEST(SfemCholesky, SingularMatrixNamesVertex) {
  Model model = body(8, Formulation::kStandard);
  // All coupling of row 40 loses its stiffness.
  BlockMatrix& k = model.stiffness;
  for (std::size_t row = 0; row < model.vertex.size(); row++)
    for (std::size_t b = k.row_begin[row]; b < k.row_begin[row + 1]; b++)
      if (row == 40 || k.column[b] == 40)
        for (std::size_t i = 0; i < 9; i++) k.value[9 * b + i] = 0;
  const auto factor = factorize(Exec(2), k, plan(model), model.vertex);
  ASSERT_FALSE(factor);
  EXPECT_NE(factor.error().message.find("vertex " + std::to_string(model.vertex[40])), std::string::npos)
      << factor.error().message;
}

}  // namespace
}  // namespace turgor::sfem
