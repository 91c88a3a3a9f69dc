// Smoothed rest positions of skin nodes. The outermost nodes of the body form stairs, and tension on stairs
// gives forces that smooth skin does not have.
#pragma once

#include <cstdint>

#include "turgor/models/lattice/build/body_nodes.hpp"

namespace turgor::lattice {

/// Index of a node in the whole body, i fastest.
inline std::int64_t number_in_body(const Lattice& lattice, Int3 node) {
  return (std::int64_t(node.z + lattice.first) * lattice.size.y + node.y) * lattice.size.x + node.x;
}

/// Positions of skin nodes after smoothing and twicing, which restores the curvature that smoothing removes.
/// [Tukey 1977] Nodes move by at most one spacing; border nodes stay.
class SmoothedSkin {
 public:
  /// `triangles`: of the whole body, even if the lattice has only some of its layers.
  SmoothedSkin(const Exec& exec, const Lattice& lattice, const std::vector<SkinNodes>& triangles);

  /// Position of a skin node along the axes of the lattice, from the first node of the body [m].
  Vec3d of(std::int64_t node) const { return position_[index_of(node)]; }

 private:
  std::size_t index_of(std::int64_t node) const;

  std::vector<std::int64_t> node_;  // ascending
  std::vector<Vec3d> position_;
};

}  // namespace turgor::lattice
