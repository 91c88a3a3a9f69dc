// K = L Lᵀ of a sparse symmetric positive definite matrix of 3×3 blocks, and solutions with it for many
// right-hand sides at once. Supernodes make both run at the speed of dense products.
#pragma once

#include <cstddef>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/core/result.hpp"
#include "turgor/core/vec.hpp"

namespace turgor::sfem {

struct BlockMatrix;

/// The factor, by supernodes: columns that have the same rows below their diagonal block.
struct Cholesky {
  std::vector<int> order;  // row of K at each place of the elimination
};

}  // namespace turgor::sfem
