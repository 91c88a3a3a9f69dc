#include "turgor/models/sfem/stored_permutation.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"

namespace turgor::sfem {

StoredPermutation stored_permutation(const Model& model, const Elimination& plan) {
  StoredPermutation stored;
  for (const int v : model.green.nodes) {
    stored.rows.push_back(model.free_node[std::size_t(v)]);
    TURGOR_CHECK(stored.rows.back() >= 0, "kept nodes are free");
    stored.position.push_back(plan.position[std::size_t(stored.rows.back())]);
    stored.by_position.push_back(int(stored.by_position.size()));
  }
  std::sort(stored.by_position.begin(), stored.by_position.end(),
            [&](int a, int b) { return stored.position[std::size_t(a)] < stored.position[std::size_t(b)]; });
  return stored;
}

}  // namespace turgor::sfem
