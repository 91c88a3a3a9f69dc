// Elimination order by nested dissection. A body is divided in two at a small set of nodes. These are
// eliminated last, the halves in the same manner before. [George 1973]
#pragma once

#include <span>
#include <vector>

#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

inline std::span<const int> neighbors(const BlockMatrix& k, int row) {
  const std::size_t begin = k.row_begin[std::size_t(row)], end = k.row_begin[std::size_t(row) + 1];
  return {k.column.data() + begin, end - begin};
}

/// Rows of K in the order of elimination, by METIS. The same for the same K, from whatever thread.
/// [Karypis, Kumar 1998]
std::vector<int> nested_dissection(const BlockMatrix& k);

}  // namespace turgor::sfem
