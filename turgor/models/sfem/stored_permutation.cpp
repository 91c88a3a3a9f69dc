#include "turgor/models/sfem/stored_permutation.hpp"

#include <algorithm>

namespace turgor::sfem {

KeptPlaces kept_places(const Model& model, const Elimination& plan) {
  KeptPlaces kept;
  for (const int v : model.green.nodes) {
    kept.rows.push_back(model.free_node[std::size_t(v)]);
    kept.place.push_back(plan.place[std::size_t(kept.rows.back())]);
    kept.by_place.push_back(int(kept.by_place.size()));
  }
  std::sort(kept.by_place.begin(), kept.by_place.end(),
            [&](int a, int b) { return kept.place[std::size_t(a)] < kept.place[std::size_t(b)]; });
  return kept;
}

}  // namespace turgor::sfem
