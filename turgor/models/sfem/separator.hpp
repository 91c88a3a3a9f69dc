// The nodes between two halves of a graph, made fewer by moving single nodes. [Fiduccia, Mattheyses 1982]
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

inline std::span<const int> neighbours(const BlockMatrix& k, int row) {
  const std::size_t begin = k.row_begin[std::size_t(row)], end = k.row_begin[std::size_t(row) + 1];
  return {k.column.data() + begin, end - begin};
}

/// Three numbers that mark the nodes of one part: its halves, and what separates them.
struct Sides {
  int low = 0, high = 1, between = 2;
};

/// No node on the low side is a neighbour of one on the high side, before and after. `side` is of every row
/// of K, those with other numbers are left out; `is_settled` too, zero before and after. Returns how many
/// nodes are left between.
std::size_t refine_separator(const BlockMatrix& k, std::span<const int> part, const Sides& sides,
                             std::vector<int>& side, std::vector<std::uint8_t>& is_settled);

}  // namespace turgor::sfem
