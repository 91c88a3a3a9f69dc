// Disjoint sets (union-find) with path halving. The smallest member represents its set; `up` holds each
// member's parent and is initialized with the identity.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace turgor {

/// Smallest member of the set.
inline int root_of(std::vector<int>& up, int n) {
  while (up[std::size_t(n)] != n) n = up[std::size_t(n)] = up[std::size_t(up[std::size_t(n)])];
  return n;
}

inline void join_sets(std::vector<int>& up, int a, int b) {
  const int root_a = root_of(up, a), root_b = root_of(up, b);
  up[std::size_t(std::max(root_a, root_b))] = std::min(root_a, root_b);
}

}  // namespace turgor
