// Functions of a touch that both the tick and the frame use: components of a displacement, sharing between
// tools, and viscosity over a tick.
#pragma once

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/models/rhombus/rhombus.hpp"

namespace turgor::rhombus {

/// Depth of the tip below the surface at rest; 0 without contact [m].
inline double pressed_depth(const FootPoint& foot, const TouchInput& in) {
  return std::max(0.0, in.radius - foot.height);
}

/// Components of the touched point's displacement, along the normal and along the surface.
struct MoveComponents {
  double depth = 0;  // inwards [m]
  double drag = 0;   // along the surface, 0 or more [m]
  Vec3d along;       // unit, or zero
};
inline MoveComponents components_of(Vec3d move, Vec3d normal) {
  const double depth = -dot(move, normal);
  const Vec3d along = move + normal * depth;
  const double drag = norm(along), whole = norm(move);
  if (!(drag > 1e-12 * whole)) return {depth, 0, {}};  // zero up to rounding
  return {depth, drag, along / drag};
}

/// A displacement shared between tools. The chain is evaluated at the whole depth at that point, and the tool
/// bears its fraction. So two tools at one point together meet the force of one.
struct SharedMove {
  double whole = 0;     // displacement for which the chain is evaluated [m]
  double fraction = 0;  // of it that this tool makes, in [0, 1]
};
inline SharedMove shared_move(double moved, double demand) {
  const double size = std::max(std::abs(moved), std::abs(demand));
  return size > 0 ? SharedMove{std::copysign(size, moved), std::abs(moved) / size} : SharedMove{};
}

/// Maxwell branch of a pair over a tick, exact for forces that change linearly in time.
struct ViscousStep {
  double kept = 1;   // decay factor of the viscous force
  double taken = 0;  // factor of the elastic force's change
};
inline ViscousStep viscous_step(const PronyPair& pair, double dt) {
  TURGOR_CHECK(pair.time > 0 && dt >= 0, "tissue relaxes in a positive time");
  const double a = dt / pair.time;
  return {std::exp(-a), a > 0 ? pair.ratio * -std::expm1(-a) / a : pair.ratio};
}

/// Viscous force of all pairs [N].
inline Vec3d remembered_force(const ToolTouch& t) {
  return t.remembered[0] + t.remembered[1] + t.remembered[2];
}

}  // namespace turgor::rhombus
