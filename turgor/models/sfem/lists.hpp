// Lists of numbers, one behind the other in one array: the elements around a vertex, the neighbors in a
// graph.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::sfem {

struct Lists {
  std::vector<std::size_t> begin{0};  // lists + 1
  std::vector<int> item;

  std::size_t count() const { return begin.size() - 1; }
  std::span<const int> operator[](std::size_t i) const {
    TURGOR_CHECK(i < count(), "the list exists");
    return {item.data() + begin[i], begin[i + 1] - begin[i]};
  }
};

/// For each number in [0, count), the lists that hold it, ascending.
inline Lists holders(const Lists& lists, std::size_t count) {
  TURGOR_CHECK(all_indices(lists.item, count), "items of the lists are numbers below the count");
  Lists result;
  result.begin.assign(count + 1, 0);
  for (const int i : lists.item) result.begin[std::size_t(i) + 1]++;
  for (std::size_t i = 0; i < count; i++) result.begin[i + 1] += result.begin[i];
  result.item.resize(lists.item.size());
  std::vector<std::size_t> next(result.begin.begin(), result.begin.end() - 1);
  for (std::size_t l = 0; l < lists.count(); l++)
    for (const int i : lists[l]) result.item[next[std::size_t(i)]++] = int(l);
  return result;
}

}  // namespace turgor::sfem
