// Edges of a triangle surface: each use of an edge by a triangle, sorted so that the uses of one edge are
// adjacent in the list. In a closed surface every edge has two uses in opposite directions.
#pragma once

#include <algorithm>
#include <span>
#include <tuple>
#include <vector>

#include "turgor/core/vec.hpp"

namespace turgor {

struct EdgeUse {
  int a = 0, b = 0;     // vertices, a < b
  int triangle = 0;     // triangle with the edge
  int side = 0;         // 0: from its first to its second vertex, 1: second to third, 2: third to first
  bool forward = true;  // the triangle runs from a to b
};

inline bool same_edge(const EdgeUse& u, const EdgeUse& v) { return u.a == v.a && u.b == v.b; }

inline std::vector<EdgeUse> sorted_edges(std::span<const Int3> triangles) {
  std::vector<EdgeUse> uses;
  uses.reserve(triangles.size() * 3);
  for (std::size_t t = 0; t < triangles.size(); t++)
    for (int side = 0; side < 3; side++) {
      const int from = triangles[t][side], to = triangles[t][(side + 1) % 3];
      uses.push_back({std::min(from, to), std::max(from, to), int(t), side, from < to});
    }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& u, const EdgeUse& v) {
    return std::tie(u.a, u.b, u.triangle, u.side) < std::tie(v.a, v.b, v.triangle, v.side);
  });
  return uses;
}

/// Calls visit(span of uses) once for every edge, in order.
template <class Visit>
void for_each_edge(std::span<const EdgeUse> uses, const Visit& visit) {
  for (std::size_t i = 0; i < uses.size();) {
    std::size_t end = i + 1;
    while (end < uses.size() && same_edge(uses[end], uses[i])) end++;
    visit(uses.subspan(i, end - i));
    i = end;
  }
}

}  // namespace turgor
