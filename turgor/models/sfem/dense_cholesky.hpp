// Dense part of a sparse factorization: the panel of one supernode and its contribution to its ancestors.
#pragma once

#include <cstddef>
#include <span>

#include "turgor/core/exec.hpp"

namespace turgor::sfem {

/// A supernode while it is factored. Both matrices are column-major, of their lower halves.
struct Front {
  std::size_t width = 0, height = 0;  // unknowns: its own, and of the rows below
  double* panel = nullptr;            // (width + height) × width
  double* rest = nullptr;             // height × height
};

/// panel = [A; B] becomes [L; B A⁻¹] with A = L Lᵀ, rest loses B A⁻¹ Bᵀ. Returns the column whose pivot is
/// not positive, -1 = none. The same bits on any number of threads.
int factor_front(const Exec& exec, const Front& front);

}  // namespace turgor::sfem
