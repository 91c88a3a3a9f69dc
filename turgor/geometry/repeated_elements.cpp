#include "turgor/geometry/repeated_elements.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "turgor/geometry/weld.hpp"

namespace turgor {

namespace {

using SortedCorners = std::array<int, 8>;  // sorted; unused entries are -1

}  // namespace

std::vector<RepeatedElement> repeated_elements(const SolidMesh& mesh) {
  const std::vector<int> first = first_coincident(mesh.vertices);
  const std::size_t corners = mesh.corners == 8 ? 8 : 4;  // the midside nodes follow from the corners
  std::vector<SortedCorners> keys(element_count(mesh));
  for (std::size_t e = 0; e < keys.size(); e++) {
    keys[e].fill(-1);
    for (std::size_t c = 0; c < corners; c++) keys[e][c] = first[std::size_t(element(mesh, e)[c])];
    std::sort(keys[e].begin(), keys[e].end());
  }
  std::vector<std::size_t> order(keys.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return keys[a] != keys[b] ? keys[a] < keys[b] : a < b; });
  std::vector<RepeatedElement> repeated;
  std::size_t start = 0;  // of the current group of equal elements
  for (std::size_t i = 1; i < order.size(); i++) {
    if (keys[order[i]] != keys[order[start]])
      start = i;
    else
      repeated.push_back({order[start], order[i]});
  }
  std::sort(repeated.begin(), repeated.end(), [](auto& a, auto& b) { return a.again < b.again; });
  return repeated;
}

}  // namespace turgor
