// A list of numbers, each once.
#pragma once

#include <algorithm>

namespace turgor {

/// Ascending, and what is there more than once is left away.
template <class List>
void sort_unique(List& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

}  // namespace turgor
