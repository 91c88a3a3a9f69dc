// Where the skin lies in the CT, between the steps of the lattice. Its nodes are the outermost of the body,
// whose stairs would pull where smooth skin does not.
#pragma once

#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

/// Places of the skin's corners: its triangles, given by their slots, smoothed, and what that takes from
/// curved skin given back; no further than a step from their nodes. The border of the skin stays. [twicing:
/// Tukey 1977]
class SkinPlaces {
 public:
  SkinPlaces(const Exec& exec, const Lattice& lattice, const std::vector<SkinTriangle>& triangles);

  /// Lattice frame [m].
  Vec3d operator[](int slot) const { return place_[std::size_t(number_[std::size_t(slot)])]; }

 private:
  std::vector<int> number_;  // by slot; −1: no skin
  std::vector<Vec3d> place_;
};

}  // namespace turgor::lattice
