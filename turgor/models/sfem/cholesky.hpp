// Factorization K = L D Lᵀ of a sparse symmetric positive definite matrix of 3×3 blocks, and solutions for
// many right-hand sides at once. D has one dense block a supernode. So both run at the speed of dense
// products, and solutions for unit forces touch only the entries that they need. [Duff, Reid 1983; Liu 1992]
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/core/result.hpp"
#include "turgor/models/sfem/elimination.hpp"

namespace turgor::sfem {

/// Each supernode's panel, column-major: the Cholesky factor of its block of D on top (lower triangle), its
/// rows of L below.
struct Cholesky {
  Elimination plan;
  std::vector<double> values;
};

/// Error: K is not positive definite; `vertex` names the rows. The same bits on any number of threads.
Result<Cholesky> factorize(const Exec& exec, const BlockMatrix& k, Elimination plan,
                           std::span<const int> vertex, const Progress& progress = {});

/// Solves K u = f for one right-hand side, overwritten by the solution, in the order of K's rows.
void solve(const Cholesky& factor, std::span<double> f);
/// Solves for many right-hand sides, stored one after the other.
void solve(const Exec& exec, const Cholesky& factor, std::span<double> f);

/// Columns of K⁻¹, computed by solve_units.
struct UnitSolutions {
  std::size_t columns = 0;     // 3 · the number of units
  std::vector<double> values;  // row-major, by position in the elimination order
  std::vector<double> gathered;

  const double* row(int position) const { return &values[3 * std::size_t(position) * columns]; }
};

/// Solutions for unit forces along the three axes at these rows of K. They are computed at the positions of
/// the supernodes that are `wanted` (with their ancestors) and not before `first_position`; other values are
/// undefined.
void solve_units(const Cholesky& factor, std::span<const int> rows, std::span<const unsigned char> wanted,
                 int first_position, UnitSolutions& solutions);

/// Operations of solving for one right-hand side without zeros.
inline double solve_flops(const Elimination& plan) { return 4 * double(plan.value_count); }

}  // namespace turgor::sfem
