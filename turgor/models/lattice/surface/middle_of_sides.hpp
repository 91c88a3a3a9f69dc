// Middle of a cut between its displaced sides.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "turgor/core/vec.hpp"

namespace turgor::lattice::detail {

/// Mean of the sides of a cut, where some vertices coincided at rest. A side may have several of them.
template <class Vertex>
Vec3 middle_of_sides(std::span<const Vertex> group, const std::vector<Vec3>& x) {
  const auto at = [&](Vertex v) { return x[std::size_t(v)]; };
  Real widest = 0;
  for (const Vertex a : group)
    for (const Vertex b : group) widest = std::max(widest, norm(at(a) - at(b)));
  if (!(widest > 0)) return at(group.front());
  // each vertex counts by the share that it has of its side
  Vec3 sum;
  Real total = 0;
  for (const Vertex a : group) {
    Real same_side = 0;
    for (const Vertex b : group) same_side += std::max(Real(0), 1 - 4 * norm(at(a) - at(b)) / widest);
    sum += at(a) / same_side, total += 1 / same_side;
  }
  return sum / total;
}

}  // namespace turgor::lattice::detail
