// Small dense linear systems without symmetry, solved in caller-owned storage: the Newton steps of a haptic
// tick.
#pragma once

#include <cstddef>

namespace turgor::contact {

/// A square system. Columns are padded with zeros to whole lanes (kLanes of coulomb_steps.hpp).
struct DenseSystem {
  static constexpr int kPanel = 4;  // columns that are eliminated at once

  double* a;        // column-major
  double* rhs;      // padded as a column
  double* factors;  // workspace of kPanel columns
  int n = 0;        // unknowns
  int stride = 0;   // numbers between columns, a multiple of kLanes

  double* column(int j) const { return a + std::size_t(j) * std::size_t(stride); }
};

/// Solves the system by Gaussian elimination; rows are exchanged where a pivot is less than a tenth of an
/// entry below it. The solution replaces `rhs`, the factors replace `a`. False for a singular matrix.
bool solve_in_place(const DenseSystem& system);

}  // namespace turgor::contact
