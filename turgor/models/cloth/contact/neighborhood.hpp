// Neighborhoods of adjacent large triangles or edges, filtered sixteen at a time on a CPU
// (large_primitives.hpp).
#pragma once

#include <bit>
#include <vector>

#include "turgor/models/cloth/contact/large_primitives.hpp"

namespace turgor::cloth {

/// Vertices or edges near a block of adjacent triangles or edges: candidates of all of these.
struct Neighborhood {
  std::vector<int> index;   // of vertices or edges
  Vectors at, rest;         // positions of vertices, or midpoints of edges [m]
  Vectors edge, rest_edge;  // of edges: vectors from end to end [m]
};

inline unsigned passing(const NearTriangle& filter, const Neighborhood& near, std::size_t n) {
  return filter.passes<Lanes>(load(near.at, n), load(near.rest, n));
}
inline unsigned passing(const NearEdge& filter, const Neighborhood& near, std::size_t n) {
  return filter.passes<Lanes>(load(near.at, n), load(near.edge, n), load(near.rest, n),
                              load(near.rest_edge, n));
}

/// Calls visit(index) for all candidates that pass the filter, sixteen at a time.
template <class Filter, class Visit>
void visit_neighbors(const Neighborhood& near, const Filter& filter, const Visit& visit) {
  for (std::size_t n = 0; n < near.index.size(); n += std::size_t(kLanes)) {
    unsigned hits = passing(filter, near, n);
    if (const std::size_t remaining = near.index.size() - n; remaining < std::size_t(kLanes))
      hits &= (1u << remaining) - 1;
    for (; hits != 0; hits &= hits - 1) visit(near.index[n + std::size_t(std::countr_zero(hits))]);
  }
}

}  // namespace turgor::cloth
