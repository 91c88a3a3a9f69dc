// Where the skin lies in the CT, between the steps of the lattice. Its nodes are the outermost of the body,
// whose stairs would pull where smooth skin does not.
#pragma once

#include <cstdint>

#include "turgor/models/lattice/build/body_nodes.hpp"

namespace turgor::lattice {

/// The number of a node of a lattice among those of the whole body, i fastest.
inline std::int64_t number_in_body(const Lattice& lattice, Int3 node) {
  return (std::int64_t(node.z + lattice.first) * lattice.size.y + node.y) * lattice.size.x + node.x;
}

/// Places of the skin's corners: its triangles, smoothed, and what that takes from curved skin given back; no
/// further than a step from their nodes. The border of the skin stays. [twicing: Tukey 1977]
class SkinPlaces {
 public:
  /// Of all triangles of the body, also where the lattice is a part of it.
  SkinPlaces(const Exec& exec, const Lattice& lattice, const std::vector<SkinNodes>& triangles);

  /// Of a node with skin, along the lattice's axes from the body's first node [m].
  Vec3d of(std::int64_t node) const { return place_[index_of(node)]; }

 private:
  std::size_t index_of(std::int64_t node) const;

  std::vector<std::int64_t> node_;  // ascending
  std::vector<Vec3d> place_;
};

}  // namespace turgor::lattice
