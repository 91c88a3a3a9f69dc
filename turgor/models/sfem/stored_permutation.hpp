// Positions of the stored nodes (those with Green's functions) in the elimination order.
#pragma once

#include <vector>

#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

struct StoredPermutation {
  std::vector<int> by_position;  // slots of Green::nodes, by ascending position
  std::vector<int> position;     // of each slot
  std::vector<int> rows;         // of K, of each slot
};
StoredPermutation stored_permutation(const Model& model, const Elimination& plan);

}  // namespace turgor::sfem
