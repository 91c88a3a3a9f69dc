// What large triangles and edges that lie side by side have around them, sieved sixteen at a time on a CPU
// (large_primitives.hpp).
#pragma once

#include <bit>
#include <vector>

#include "turgor/models/cloth/contact/large_primitives.hpp"

namespace turgor::cloth {

/// What is near to some triangles or edges that lie side by side: all that any of them has to look at.
struct Neighborhood {
  std::vector<int> index;  // of vertices, or edges
  Vectors at, rest;        // their places, or edges' middles [m]
  Vectors way, rest_way;   // of edges, to their ends [m]
};

inline unsigned passing(const NearTriangle& sieve, const Neighborhood& near, std::size_t n) {
  return sieve.passes<Lanes>(load(near.at, n), load(near.rest, n));
}
inline unsigned passing(const NearEdge& sieve, const Neighborhood& near, std::size_t n) {
  return sieve.passes<Lanes>(load(near.at, n), load(near.way, n), load(near.rest, n), load(near.rest_way, n));
}

/// Calls visit(index) for all there that pass the sieve, sixteen at a time.
template <class Sieve, class Visit>
void visit_neighbors(const Neighborhood& near, const Sieve& sieve, const Visit& visit) {
  for (std::size_t n = 0; n < near.index.size(); n += std::size_t(kLanes)) {
    unsigned hits = passing(sieve, near, n);
    if (const std::size_t left = near.index.size() - n; left < std::size_t(kLanes)) hits &= (1u << left) - 1;
    for (; hits != 0; hits &= hits - 1) visit(near.index[n + std::size_t(std::countr_zero(hits))]);
  }
}

}  // namespace turgor::cloth
