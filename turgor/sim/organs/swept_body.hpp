// The lattice of a swept contact or attachment (swept.hpp).
#pragma once

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/sim/organs/support.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// Support of a swept body, or of a body that it touches.
inline const CoupledSupport& swept_support(const World& world, int index) {
  const int n = index - first_support(world);
  TURGOR_CHECK(is_index(n, world.coupling.supports.size()), "swept bodies and what they touch are supports");
  return world.coupling.supports[std::size_t(n)];
}
inline const LatticeBody& lattice_of(const World& world, const CoupledSupport& support) {
  return world.lattice_bodies[std::size_t(support.body.index)];
}
inline const Mat3d& patient_axes(const LatticeBody& body) { return body.model.anatomy.grid.axes; }

/// Motion of a point in the next frame at its present velocity; zero for chains and what is fixed [m].
Vec3d motion_ahead(const World& world, const contact::SurfacePoint& point);

/// True if a contact or an attachment is solved in the sweeps of this lattice.
inline bool is_swept_by(const World& world, const LatticeBody& body, int index) {
  return index >= first_support(world) && swept_support(world, index).body.kind == BodyKind::kLattice &&
         &lattice_of(world, swept_support(world, index)) == &body;
}

}  // namespace turgor
