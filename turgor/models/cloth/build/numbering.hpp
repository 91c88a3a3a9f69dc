// An order of vertices in which those that springs join are near each other in memory: part by part, and in a
// part as in the mesh when that is good enough, else by distance from an end [Cuthill, McKee 1969].
#pragma once

#include <vector>

#include "turgor/models/cloth/model/rows.hpp"

namespace turgor::cloth {

struct Numbering {
  std::vector<int> order;       // old numbers, in the new order
  std::vector<int> part_begin;  // in the new order, and the end
};
Numbering number_vertices(const std::vector<Spring>& springs, int count);

}  // namespace turgor::cloth
