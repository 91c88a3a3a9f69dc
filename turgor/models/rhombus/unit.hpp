// One rhombus of the chain [RC eqs. 1-7, with the sign of the k_T term and the angle corrected: see
// docs/models/rhombus.md]. It stands on its tip, and its sides a have the angle θ with the surface. Its
// normal diagonal l = 2a sin θ carries the spring k_N, its tangential one v = 2a cos θ the spring k_T.
// Rotated to φ = θ + Δθ,
//
//     Δl = 2a (sin φ − sin θ)      Δv = 2a (cos φ − cos θ) = −tan(θ + Δθ/2) Δl
//     E  = ½ k_N Δl² + ½ k_T Δv²
//     F  = dE/dl  = (k_N + k_T tan(θ + Δθ/2) tan φ) Δl
//     K  = dF/dl  = k_N + k_T (cos θ / cos³φ − 1)
//
// When pressed, the tangential spring loses its effect. Below the angle φc with cos³φc = cos θ it would push
// the unit flat (K < k_N, negative for stiff k_T). When pulled, K would grow without bound as φ → 90°, unlike
// any tissue. The unit therefore has a stop at either end. Past a stop K grows exponentially, by e over a
// length b:
//
//     F = F_stop ± K_stop b (e^(x/b) − 1)      x past the stop; b = lc/2 pressed, l at rest / stiffening
//     pulled
//
// Before it K grows more slowly. So |dK/dF| ≤ 1/b everywhere.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "turgor/core/config.hpp"

namespace turgor::rhombus {

/// State at a stop, past which the stiffness grows by e over each `rise`.
struct UnitStop {
  double length = 0;     // l at the stop [m]
  double tangent = 0;    // tan φ at the stop
  double force = 0;      // F at the stop; negative: pressed [N]
  double stiffness = 0;  // K at the stop [N/m]
  double energy = 0;     // E at the stop [J]
  double rise = 0;       // b [m]
};

/// A rhombus with its derived values. Made by make_unit.
struct Unit {
  double side = 0;        // a [m]
  double angle = 0;       // θ at rest [rad]
  double normal = 0;      // k_N [N/m]
  double tangential = 0;  // k_T [N/m]

  double sin_rest = 0, cos_rest = 0;  // of θ
  UnitStop pressed, pulled;
};

/// State of a loaded unit: lengthened for F > 0, shortened for F < 0.
struct TurnedUnit {
  double normal_change = 0;      // Δl [m]
  double tangential_change = 0;  // Δv [m]
  double stiffness = 0;          // K = dF/dl [N/m]
};

TURGOR_HD inline double rest_length(const Unit& unit) { return 2 * unit.side * unit.sin_rest; }
TURGOR_HD inline double rest_width(const Unit& unit) { return 2 * unit.side * unit.cos_rest; }

/// Δl of a rotation Δθ in [−θ, 90° − θ].
TURGOR_HD inline double normal_change(const Unit& unit, double turn) {
  return 4 * unit.side * std::cos(unit.angle + turn / 2) * std::sin(turn / 2);
}
/// Δv of a rotation Δθ.
TURGOR_HD inline double tangential_change(const Unit& unit, double turn) {
  return -4 * unit.side * std::sin(unit.angle + turn / 2) * std::sin(turn / 2);
}

/// F and E past a stop by x ≥ 0; `sign` is that of F [N] [J].
TURGOR_HD inline double force_past(const UnitStop& stop, double x, double sign) {
  return stop.force + sign * stop.stiffness * stop.rise * std::expm1(x / stop.rise);
}
TURGOR_HD inline double energy_past(const UnitStop& stop, double x, double sign) {
  const double b = stop.rise;
  return stop.energy + sign * stop.force * x + stop.stiffness * b * (b * std::expm1(x / b) - x);
}

/// E of a unit with these changes of its diagonals [J].
TURGOR_HD inline double energy_of_changes(const Unit& unit, double dl, double dv) {
  const double l = rest_length(unit) + dl;
  if (l < unit.pressed.length) return energy_past(unit.pressed, unit.pressed.length - l, -1);
  if (l > unit.pulled.length) return energy_past(unit.pulled, l - unit.pulled.length, 1);
  return 0.5 * (unit.normal * dl * dl + unit.tangential * dv * dv);
}
/// E [J].
TURGOR_HD inline double unit_energy(const Unit& unit, double turn) {
  return energy_of_changes(unit, normal_change(unit, turn), tangential_change(unit, turn));
}
/// F = dE/dl [N].
TURGOR_HD inline double unit_force(const Unit& unit, double turn) {
  const double dl = normal_change(unit, turn), l = rest_length(unit) + dl;
  if (l < unit.pressed.length) return force_past(unit.pressed, unit.pressed.length - l, -1);
  if (l > unit.pulled.length) return force_past(unit.pulled, l - unit.pulled.length, 1);
  return (unit.normal + unit.tangential * std::tan(unit.angle + turn / 2) * std::tan(unit.angle + turn)) * dl;
}
/// K = dF/dl of a rhombus between its stops, with its sides at the angle φ [N/m].
TURGOR_HD inline double stiffness_at_angle(const Unit& unit, double angle) {
  const double cosine = std::cos(angle);
  return unit.normal + unit.tangential * (unit.cos_rest / (cosine * cosine * cosine) - 1);
}
/// K = dF/dl [N/m].
TURGOR_HD inline double unit_stiffness(const Unit& unit, double turn) {
  const double l = rest_length(unit) + normal_change(unit, turn);
  if (l < unit.pressed.length)
    return unit.pressed.stiffness * std::exp((unit.pressed.length - l) / unit.pressed.rise);
  if (l > unit.pulled.length)
    return unit.pulled.stiffness * std::exp((l - unit.pulled.length) / unit.pulled.rise);
  return stiffness_at_angle(unit, unit.angle + turn);
}

/// d ln K / dl of a rhombus between its stops, with its sides at the angle φ [1/m].
inline double growth_at_angle(const Unit& unit, double angle) {
  const double cosine = std::cos(angle);
  return 3 * unit.tangential * unit.cos_rest * std::sin(angle) /
         (2 * unit.side * std::pow(cosine, 5) * stiffness_at_angle(unit, angle));
}
/// Angle between rest and upright at which K starts to grow faster than by e over `rise` [rad].
inline double pulled_stop_angle(const Unit& unit, double rise) {
  double low = unit.angle, high = std::numbers::pi / 2;
  if (growth_at_angle(unit, low) * rise >= 1) return low;
  for (int i = 0; i < 60; i++) {
    const double middle = 0.5 * (low + high);
    (growth_at_angle(unit, middle) * rise < 1 ? low : high) = middle;
  }
  return low;
}
inline UnitStop stop_at(const Unit& unit, double angle, double rise) {
  const double dl = 2 * unit.side * (std::sin(angle) - unit.sin_rest),
               dv = 2 * unit.side * (std::cos(angle) - unit.cos_rest);
  const double tangent = std::tan(angle);
  return {2 * unit.side * std::sin(angle),
          tangent,
          unit.normal * dl - unit.tangential * dv * tangent,
          stiffness_at_angle(unit, angle),
          0.5 * (unit.normal * dl * dl + unit.tangential * dv * dv),
          rise};
}

/// Builds a unit, with θ in (0, 90°) [rad] and all other parameters positive. `stiffening`: largest
/// logarithmic growth of K over a pull by the unit's own height.
inline Unit make_unit(double side, double angle, double normal, double tangential, double stiffening) {
  Unit unit{.side = side, .angle = angle, .normal = normal, .tangential = tangential};
  unit.sin_rest = std::sin(angle), unit.cos_rest = std::cos(angle);
  const double pressed_angle = std::acos(std::cbrt(unit.cos_rest));
  unit.pressed = stop_at(unit, pressed_angle, side * std::sin(pressed_angle));
  const double rise = rest_length(unit) / stiffening;
  unit.pulled = stop_at(unit, pulled_stop_angle(unit, rise), rise);
  return unit;
}

/// State of a unit past a stop: the sides stretch or shorten along l, v is constant.
inline TurnedUnit turned_past(const Unit& unit, const UnitStop& stop, double force) {
  const double sign = stop.length < rest_length(unit) ? -1 : 1;
  const double growth = 1 + std::abs(force - stop.force) / (stop.stiffness * stop.rise);
  const double cosine = 1 / std::sqrt(1 + stop.tangent * stop.tangent);
  return {stop.length + sign * stop.rise * std::log(growth) - rest_length(unit),
          2 * unit.side * (cosine - unit.cos_rest), stop.stiffness * growth};
}

/// State of a unit under a force. With t = tan φ, F / 2a = (k_N − k_T) sin φ + k_T cos θ t − k_N sin θ. It is
/// monotonic and of one curvature, so Newton's steps approach the root from one side.
inline TurnedUnit turn_by_force(const Unit& unit, double force) {
  const double a2 = 2 * unit.side;
  const double rest_tangent = unit.sin_rest / unit.cos_rest;
  if (force == 0) return {0, 0, unit.normal + unit.tangential * rest_tangent * rest_tangent};
  if (force < unit.pressed.force) return turned_past(unit, unit.pressed, force);
  if (force > unit.pulled.force) return turned_past(unit, unit.pulled, force);
  const double stiffness_difference = unit.normal - unit.tangential,
               tangential_term = unit.tangential * unit.cos_rest;
  const double goal = force / a2 + unit.normal * unit.sin_rest;
  const double rest_slope =
      stiffness_difference * unit.cos_rest * unit.cos_rest * unit.cos_rest + tangential_term;
  double t = rest_tangent + force / a2 / rest_slope;
  double cosine = 1;
  for (int i = 0; i < 30; i++) {
    t = std::clamp(t, unit.pressed.tangent, unit.pulled.tangent);
    cosine = 1 / std::sqrt(1 + t * t);
    const double step = (stiffness_difference * t * cosine + tangential_term * t - goal) /
                        (stiffness_difference * cosine * cosine * cosine + tangential_term);
    t -= step;
    if (std::abs(step) <= 1e-9 * (1 + t)) break;  // the omitted step would change t by the square of this
  }
  t = std::clamp(t, unit.pressed.tangent, unit.pulled.tangent);
  cosine = 1 / std::sqrt(1 + t * t);
  const double dl = a2 * (t * cosine - unit.sin_rest), dv = a2 * (cosine - unit.cos_rest);
  return {dl, dv, unit.normal + unit.tangential * (unit.cos_rest / (cosine * cosine * cosine) - 1)};
}

}  // namespace turgor::rhombus
