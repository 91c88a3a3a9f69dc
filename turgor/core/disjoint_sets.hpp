// Which of many things belong together, as pairs of them are joined. A set is named by its least member: `up`
// leads from each member towards it, and is its own number at first.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace turgor {

/// The least member of the set.
inline int root_of(std::vector<int>& up, int n) {
  while (up[std::size_t(n)] != n) n = up[std::size_t(n)] = up[std::size_t(up[std::size_t(n)])];
  return n;
}

inline void join_sets(std::vector<int>& up, int a, int b) {
  const int root_a = root_of(up, a), root_b = root_of(up, b);
  up[std::size_t(std::max(root_a, root_b))] = std::min(root_a, root_b);
}

}  // namespace turgor
