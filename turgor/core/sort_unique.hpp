// Sorting without duplicates.
#pragma once

#include <algorithm>

namespace turgor {

/// Sorts in ascending order and removes duplicates.
template <class List>
void sort_unique(List& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

}  // namespace turgor
