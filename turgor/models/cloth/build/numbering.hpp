// Numbering of vertices by connected component, with neighbors near each other in memory. Within a component
// it is that of the mesh if good enough, else by distance from an end [Cuthill, McKee 1969].
#pragma once

#include <vector>

#include "turgor/models/cloth/model/rows.hpp"

namespace turgor::cloth {

struct Numbering {
  std::vector<int> order;            // old numbers in the new order
  std::vector<int> component_begin;  // first vertex of each component in the new order, and the end
};
Numbering number_vertices(const std::vector<Spring>& springs, int count);

}  // namespace turgor::cloth
