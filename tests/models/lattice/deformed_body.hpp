// Bodies under a uniform deformation.
#pragma once

#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

/// Moves all nodes to x = F X.
inline void deform(const Model& model, State& state, const Mat3d& f) {
  const Lattice& l = model.anatomy.lattice;
  for (int k = 0; k < l.size.z; k++)
    for (int j = 0; j < l.size.y; j++)
      for (int i = 0; i < l.size.x; i++) {
        const Vec3d x(rest_position(l, {i, j, k}));
        state.motion.u.set(std::size_t(node_slot(l, {i, j, k})), Vec3(f * x - x));
      }
}

}  // namespace turgor::lattice
