// One rhombus of the chain [RC eqs. 1-7, with the sign of the k_T term and the angle corrected: see
// docs/models/rhombus.md]. It stands on its tip: its sides a make the angle θ with the surface, its normal
// diagonal l = 2a sin θ carries the spring k_N, its tangential one v = 2a cos θ the spring k_T. Turned to φ =
// θ + Δθ it holds
//
//     Δl = 2a (sin φ − sin θ)      Δv = 2a (cos φ − cos θ) = −tan(θ + Δθ/2) Δl
//     E  = ½ k_N Δl² + ½ k_T Δv²
//     F  = dE/dl  = (k_N + k_T tan(θ + Δθ/2) tan φ) Δl
//     K  = dF/dl  = k_N + k_T (cos θ / cos³φ − 1)
//
// Pulled, K grows without bound as φ → 90°. Pressed, the tangential spring loses its grip and, below the
// angle φc where cos³φc = cos θ, would push the unit flat (K < k_N, negative for stiff k_T). There the unit
// meets its stop: it goes on with K = k_N (lc / l)², which grows without bound as l → 0.
#pragma once

#include <cmath>
#include <limits>

#include "turgor/core/config.hpp"

namespace turgor::rhombus {

/// A rhombus and what follows from its four numbers. Made by make_unit.
struct Unit {
  double side = 0;        // a [m]
  double angle = 0;       // θ at rest [rad]
  double normal = 0;      // k_N [N/m]
  double tangential = 0;  // k_T [N/m]

  double sin_rest = 0, cos_rest = 0;  // of θ
  double stop_length = 0;             // lc [m]
  double stop_tangent = 0;            // tan φc
  double stop_force = 0;              // F there; negative: pressed [N]
  double stop_energy = 0;             // E there [J]
};

/// A unit under load: lengthened when F > 0, shortened when F < 0.
struct TurnedUnit {
  double normal_change = 0;      // Δl [m]
  double tangential_change = 0;  // Δv [m]
  double stiffness = 0;          // K = dF/dl [N/m]
};

TURGOR_HD inline double rest_length(const Unit& unit) { return 2 * unit.side * unit.sin_rest; }
TURGOR_HD inline double rest_width(const Unit& unit) { return 2 * unit.side * unit.cos_rest; }

/// Δl of a turn Δθ in [−θ, 90° − θ].
TURGOR_HD inline double normal_change(const Unit& unit, double turn) {
  return 4 * unit.side * std::cos(unit.angle + turn / 2) * std::sin(turn / 2);
}
/// Δv of a turn Δθ.
TURGOR_HD inline double tangential_change(const Unit& unit, double turn) {
  return -4 * unit.side * std::sin(unit.angle + turn / 2) * std::sin(turn / 2);
}
/// Is the unit pressed flatter than its stop allows freely?
TURGOR_HD inline bool is_stopped(const Unit& unit, double turn) {
  return rest_length(unit) + normal_change(unit, turn) < unit.stop_length;
}

/// E of a unit whose length is lc + beyond, beyond < 0: ∫ F dl past the stop [J].
TURGOR_HD inline double stopped_energy(const Unit& unit, double beyond) {
  const double lc = unit.stop_length;
  return unit.stop_energy + unit.stop_force * beyond +
         unit.normal * lc * (beyond - lc * std::log1p(beyond / lc));
}
/// E [J]; infinite when flat.
TURGOR_HD inline double unit_energy(const Unit& unit, double turn) {
  const double dl = normal_change(unit, turn), dv = tangential_change(unit, turn);
  if (!is_stopped(unit, turn)) return 0.5 * (unit.normal * dl * dl + unit.tangential * dv * dv);
  return stopped_energy(unit, rest_length(unit) + dl - unit.stop_length);
}
/// F = dE/dl [N]; −∞ when flat.
TURGOR_HD inline double unit_force(const Unit& unit, double turn) {
  const double dl = normal_change(unit, turn);
  if (!is_stopped(unit, turn))
    return (unit.normal + unit.tangential * std::tan(unit.angle + turn / 2) * std::tan(unit.angle + turn)) *
           dl;
  const double lc = unit.stop_length, l = rest_length(unit) + dl;
  return unit.stop_force + unit.normal * lc * (l - lc) / l;
}
/// K = dF/dl [N/m].
TURGOR_HD inline double unit_stiffness(const Unit& unit, double turn) {
  const double l = rest_length(unit) + normal_change(unit, turn);
  if (is_stopped(unit, turn)) return unit.normal * (unit.stop_length / l) * (unit.stop_length / l);
  const double cosine = std::cos(unit.angle + turn);
  return unit.normal + unit.tangential * (unit.cos_rest / (cosine * cosine * cosine) - 1);
}

/// θ in (0, 90°) [rad], all others positive.
inline Unit make_unit(double side, double angle, double normal, double tangential) {
  Unit unit{.side = side, .angle = angle, .normal = normal, .tangential = tangential};
  unit.sin_rest = std::sin(angle), unit.cos_rest = std::cos(angle);
  const double cosine = std::cbrt(unit.cos_rest), sine = std::sqrt((1 - cosine) * (1 + cosine));
  unit.stop_length = 2 * side * sine, unit.stop_tangent = sine / cosine;
  const double dl = unit.stop_length - rest_length(unit), dv = 2 * side * (cosine - unit.cos_rest);
  unit.stop_force = normal * dl - tangential * dv * unit.stop_tangent;
  unit.stop_energy = 0.5 * (normal * dl * dl + tangential * dv * dv);
  return unit;
}

/// The unit under a force. With t = tan φ, F / 2a = (k_N − k_T) sin φ + k_T cos θ t − k_N sin θ: rising, and
/// bent to one side only, so Newton's steps approach the root from one side.
inline TurnedUnit turn_by_force(const Unit& unit, double force) {
  const double a2 = 2 * unit.side, rest = rest_length(unit);
  const double rest_tangent = unit.sin_rest / unit.cos_rest;
  if (force == 0) return {0, 0, unit.normal + unit.tangential * rest_tangent * rest_tangent};
  if (force < unit.stop_force) {
    const double l = unit.stop_length / (1 - (force - unit.stop_force) / (unit.normal * unit.stop_length));
    const double sine = l / a2, cosine = std::sqrt((1 - sine) * (1 + sine)), ratio = unit.stop_length / l;
    return {l - rest, a2 * (cosine - unit.cos_rest), unit.normal * ratio * ratio};
  }
  const double apart = unit.normal - unit.tangential, upright = unit.tangential * unit.cos_rest;
  const double goal = force / a2 + unit.normal * unit.sin_rest;
  const double rest_slope = apart * unit.cos_rest * unit.cos_rest * unit.cos_rest + upright;
  double t = rest_tangent + force / a2 / rest_slope;
  double cosine = 1;
  for (int i = 0; i < 30; i++) {
    if (t < unit.stop_tangent) t = unit.stop_tangent;
    cosine = 1 / std::sqrt(1 + t * t);
    const double step =
        (apart * t * cosine + upright * t - goal) / (apart * cosine * cosine * cosine + upright);
    t -= step;
    if (std::abs(step) <= 1e-9 * (1 + t)) break;  // squared by the next step, which is not needed
  }
  if (t < unit.stop_tangent) t = unit.stop_tangent;
  cosine = 1 / std::sqrt(1 + t * t);
  const double dl = a2 * (t * cosine - unit.sin_rest), dv = a2 * (cosine - unit.cos_rest);
  return {dl, dv, unit.normal + unit.tangential * (unit.cos_rest / (cosine * cosine * cosine) - 1)};
}

}  // namespace turgor::rhombus
