// Where the nodes whose Green's functions are kept come in the order of elimination.
#pragma once

#include <vector>

#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

struct KeptPlaces {
  std::vector<int> by_place;  // slots of Green::nodes, ascending places
  std::vector<int> place;     // of each slot
  std::vector<int> rows;      // of K, of each slot
};
KeptPlaces kept_places(const Model& model, const Elimination& plan);

}  // namespace turgor::sfem
