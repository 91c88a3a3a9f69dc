// What a tick and a picture both need of a touch: its move in parts, and how much of a force the material
// keeps over a tick.
#pragma once

#include <algorithm>
#include <cmath>

#include "turgor/models/rhombus/rhombus.hpp"

namespace turgor::rhombus {

/// How deep the tip is below the surface at rest; 0 when it does not reach it [m].
inline double pressed_depth(const Foot& foot, const TouchInput& in) {
  return std::max(0.0, in.radius - foot.height);
}

/// A move of the touched point, along the normal and along the surface.
struct MoveParts {
  double depth = 0;  // inwards [m]
  double drag = 0;   // along the surface, 0 or more [m]
  Vec3d along;       // unit, or zero
};
inline MoveParts parts_of(Vec3d move, Vec3d normal) {
  const double depth = -dot(move, normal);
  const Vec3d along = move + normal * depth;
  const double drag = norm(along), whole = norm(move);
  if (!(drag > 1e-12 * whole)) return {depth, 0, {}};  // rounding
  return {depth, drag, along / drag};
}

/// A chain that tools share is as soft as it is at the whole depth there, and this tool takes its part of it.
/// So two tools at one place feel together what one would.
struct SharedMove {
  double whole = 0;  // what the chain is asked for [m]
  double part = 0;   // of that, by this tool, in [0, 1]
};
inline SharedMove shared_move(double moved, double demand) {
  const double size = std::max(std::abs(moved), std::abs(demand));
  return size > 0 ? SharedMove{std::copysign(size, moved), std::abs(moved) / size} : SharedMove{};
}

/// A Maxwell branch over a tick, exact for forces that change evenly.
struct ViscousStep {
  double kept = 1;   // of what was remembered
  double taken = 0;  // of the change of the elastic force
};
inline ViscousStep viscous_step(const Viscosity& viscosity, double dt) {
  const double a = dt / viscosity.time;
  return {std::exp(-a), a > 0 ? viscosity.stiffening * -std::expm1(-a) / a : viscosity.stiffening};
}

}  // namespace turgor::rhombus
