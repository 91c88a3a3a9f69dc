// Solutions with a factor: forward substitution up the tree with L, backward down the tree with D and Lᵀ.
// Right-hand sides are row-major, so that the rows of a supernode are contiguous.
#include <Eigen/Dense>
#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/models/sfem/cholesky.hpp"

namespace turgor::sfem {

namespace {

using Eigen::Index;
using Panel = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
template <int kColumns>
using Rows = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, kColumns, kColumns == 1 ? 0 : Eigen::RowMajor>>;

/// A supernode of the factor with the right-hand sides that belong to it.
template <int kColumns>
struct Step {
  const Cholesky& factor;
  const Supernode& s;
  double* x;  // of all positions
  Index columns;
  double* gathered;  // buffer for the supernode's rows

  Index width() const { return 3 * s.count; }
  Index height() const { return 3 * Index(s.row_count); }
  Panel panel(Index row, Index rows) const {
    const Index stride = width() + height();
    return {&factor.values[s.value_begin] + row, rows, width(), Eigen::OuterStride<>(stride)};
  }
  Rows<kColumns> own() const { return {x + 3 * s.first * columns, width(), columns}; }
  Rows<kColumns> below() const { return {gathered, height(), columns}; }

  /// Calls body(number of values, values in x, values gathered) for each row below.
  template <class Body>
  void for_rows(const Body& body) const {
    const Index count = 3 * columns;
    double* rows_out = gathered;
    for (const int position : rows_of(factor.plan, s))
      body(count, x + Index(position) * count, rows_out), rows_out += count;
  }
};

template <int kColumns>
void solve_up(const Step<kColumns>& step) {
  if (step.height() == 0) return;
  step.below().noalias() = step.panel(step.width(), step.height()) * step.own();
  step.for_rows([](Index count, double* x, const double* below) {
    for (Index i = 0; i < count; i++) x[i] -= below[i];
  });
}

template <int kColumns>
void solve_pivots(const Step<kColumns>& step) {
  Rows<kColumns> own = step.own();
  const auto pivots = step.panel(0, step.width());
  pivots.template triangularView<Eigen::Lower>().solveInPlace(own);
  pivots.template triangularView<Eigen::Lower>().transpose().solveInPlace(own);
}

/// Backward substitution; all ancestors are known.
template <int kColumns>
void solve_down(const Step<kColumns>& step) {
  if (step.height() == 0) return;
  step.for_rows([](Index count, const double* x, double* below) { std::copy_n(x, count, below); });
  step.own().noalias() -= step.panel(step.width(), step.height()).transpose() * step.below();
}

template <int kColumns>
void solve_all(const Cholesky& factor, double* x, Index columns) {
  const std::vector<Supernode>& supernodes = factor.plan.supernodes;
  std::size_t most = 0;
  for (const Supernode& s : supernodes) most = std::max(most, s.row_count);
  std::vector<double> gathered(3 * most * std::size_t(columns));
  const auto step = [&](const Supernode& s) {
    return Step<kColumns>{factor, s, x, columns, gathered.data()};
  };
  for (const Supernode& s : supernodes) solve_up(step(s));
  for (std::size_t n = supernodes.size(); n-- > 0;) {
    solve_pivots(step(supernodes[n]));
    solve_down(step(supernodes[n]));
  }
}

}  // namespace

void solve(const Cholesky& factor, std::span<double> f) {
  const std::vector<int>& order = factor.plan.order;
  TURGOR_CHECK(f.size() == 3 * order.size(), "every row has three numbers");
  std::vector<double> x(f.size());
  for (std::size_t i = 0; i < x.size(); i++) x[i] = f[3 * std::size_t(order[i / 3]) + i % 3];
  solve_all<1>(factor, x.data(), 1);
  for (std::size_t i = 0; i < x.size(); i++) f[3 * std::size_t(order[i / 3]) + i % 3] = x[i];
}

void solve(const Exec& exec, const Cholesky& factor, std::span<double> f) {
  constexpr std::size_t kTogether = 48;
  const std::vector<int>& order = factor.plan.order;
  const std::size_t rows = 3 * order.size(), count = f.size() / rows;
  TURGOR_CHECK(f.size() % rows == 0, "right-hand sides are stored one after the other");
  parallel_for(exec, (count + kTogether - 1) / kTogether, [&](std::size_t block) {
    const std::size_t first = block * kTogether, columns = std::min(kTogether, count - first);
    std::vector<double> x(rows * columns);
    const auto at = [&](std::size_t i, std::size_t c) -> double& {
      return f[(first + c) * rows + 3 * std::size_t(order[i / 3]) + i % 3];
    };
    for (std::size_t i = 0; i < rows; i++)
      for (std::size_t c = 0; c < columns; c++) x[i * columns + c] = at(i, c);
    solve_all<Eigen::Dynamic>(factor, x.data(), Index(columns));
    for (std::size_t i = 0; i < rows; i++)
      for (std::size_t c = 0; c < columns; c++) at(i, c) = x[i * columns + c];
  });
}

void solve_units(const Cholesky& factor, std::span<const int> rows, std::span<const unsigned char> wanted,
                 int first_position, UnitSolutions& solutions) {
  const Elimination& plan = factor.plan;
  TURGOR_CHECK(wanted.size() == plan.supernodes.size(), "every supernode has a mark");
  const std::vector<unsigned char> on_path = with_ancestors(plan, rows);
  const std::size_t columns = solutions.columns = 3 * rows.size();
  solutions.values.resize(3 * plan.order.size() * columns);
  std::size_t most = 0;
  for (const Supernode& s : plan.supernodes) most = std::max(most, s.row_count);
  solutions.gathered.resize(3 * most * columns);
  const auto step = [&](const Supernode& s) {
    return Step<Eigen::Dynamic>{factor, s, solutions.values.data(), Index(columns),
                                solutions.gathered.data()};
  };
  // A unit force affects only its path up the tree. All other positions are zero until the backward
  // substitution.
  for (std::size_t n = 0; n < plan.supernodes.size(); n++)
    if (on_path[n]) step(plan.supernodes[n]).own().setZero();
  for (std::size_t c = 0; c < columns; c++) {
    const int position = plan.position[std::size_t(rows[c / 3])];
    solutions.values[(3 * std::size_t(position) + c % 3) * columns + c] = 1;
  }
  for (std::size_t n = 0; n < plan.supernodes.size(); n++)
    if (on_path[n]) solve_up(step(plan.supernodes[n]));
  for (std::size_t n = plan.supernodes.size(); n-- > 0;) {
    const Supernode& s = plan.supernodes[n];
    if (s.first + s.count <= first_position) break;
    if (!wanted[n]) continue;
    if (on_path[n])
      solve_pivots(step(s));
    else
      step(s).own().setZero();
    solve_down(step(s));
  }
}

}  // namespace turgor::sfem
