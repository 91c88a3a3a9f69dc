// Mechanics of a needle that do not depend on the kind of body around it: displacements that a mesh does not
// resolve, the load of the spread crack, and the length of the shaft in a track. Equations and sources are in
// needle_touch.hpp.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "turgor/contact/needle.hpp"
#include "turgor/core/vec.hpp"
#include "turgor/geometry/pose.hpp"

namespace turgor::contact {

constexpr int kMostTracks = 4;        // of one needle; a further one replaces the oldest
constexpr double kNeedleJump = 0.02;  // a needle that moves farther in a step has jumped [m]

enum class NeedlePhase : std::uint8_t { kOutside, kTouching, kInside };

/// Compliance D of a point along and across the shaft [m/N].
struct OwnCompliance {
  double along = 0, across = 0;
};
/// D of a point that stands for a length of the shaft. `log_resolved`: ln r₀, the radius that the mesh
/// resolves [m].
inline OwnCompliance own_compliance(const Needle& needle, double length, double log_resolved, double shear,
                                    double poisson) {
  constexpr double kLeastLogarithm = 0.4;  // of r₀/a, where the mesh is finer than the needle
  if (!(length > 0)) return {};
  const double radius = needle.diameter / 2;
  const double log = std::max(kLeastLogarithm, log_resolved - std::log(radius));
  const double along = log / (2 * std::numbers::pi * shear * length);
  return {along, along * (3 - 4 * poisson) / (4 * (1 - poisson))};
}
/// Energy ½ λ D λ [J].
inline double own_energy(const OwnCompliance& own, Vec3d force, Vec3d t) {
  const double along = dot(force, t);
  return 0.5 * (own.along * along * along + own.across * (dot(force, force) - along * along));
}

/// Shaft behind a tip, and the part of it that has left the body at the end of a track.
struct InsertedShaft {
  double inserted = 0;  // behind the entry of the track [m]
  double beyond = 0;    // behind its end, if it is through the body [m]
};
/// Force of the spread crack on the tip, and the energy stored in it [N] [J]. A part of the cone may have
/// left the body.
inline double spreading_force(const Needle& needle, const InsertedShaft& shaft) {
  if (!(shaft.inserted > 0)) return 0;
  return needle.spreading * (cross_section(needle, shaft.inserted) - cross_section(needle, shaft.beyond));
}
inline double spreading_energy(const Needle& needle, const InsertedShaft& shaft) {
  return needle.spreading *
         (volume_behind_tip(needle, shaft.inserted) - volume_behind_tip(needle, shaft.beyond));
}

/// Points between which the load of the spread crack acts.
struct SpreadPoints {
  std::size_t before = 0, next = 0;
  double share = 0;  // of `next`
};
/// Points of a track (the end of the crack, then points from the entry on) around a tip.
template <class Points>
SpreadPoints spread_points(const Points& points, double inserted, double spacing) {
  const double cell = inserted / spacing - 0.5;
  const auto before = std::size_t(std::max(0.0, std::floor(cell))) + 1;
  if (cell <= 0 && points.size() > 1) return {1, 1, 1};
  if (before >= points.size()) return {0, 0, 1};
  const std::size_t next = before + 1 < points.size() ? before + 1 : 0;
  const double from = points[before].arc, to = points[next].arc;
  return {before, next, to > from ? std::clamp((inserted - from) / (to - from), 0.0, 1.0) : 1};
}

/// Length of a track behind the tip; negative: the tip is in front of the entry [m]. ahead(i): position of a
/// point along the push, relative to the tip [m].
template <class Track, class Ahead>
double inserted_length(const Track& track, const Ahead& ahead_of) {
  // first point that is not behind the tip
  double arc = 0, ahead = 0;
  bool has_point = false;
  for (std::size_t n = 1; n <= track.points.size(); n++) {
    const std::size_t i = n < track.points.size() ? n : 0;  // the end is the last one
    const double at = ahead_of(i);
    if (at >= 0) {
      if (!has_point || at - ahead <= 0) return track.points[i].arc - at;
      return arc + (track.points[i].arc - arc) * -ahead / (at - ahead);
    }
    arc = track.points[i].arc, ahead = at, has_point = true;
  }
  return track.is_through ? track.length - ahead : track.length;
}

/// Track for a new crack: an unused one, else the oldest.
template <class Tracks>
std::size_t next_track(const Tracks& tracks) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < tracks.size(); i++)
    if (!tracks[best].points.empty() && (tracks[i].points.empty() || tracks[i].order < tracks[best].order))
      best = i;
  return best;
}

/// Work of a hand that moves a needle; the sums are those of its forces and torques at both ends [J].
inline double hand_work(const Pose& from, const Pose& to, Vec3d force_sum, Vec3d torque_sum) {
  Vec3d turn;
  for (int axis = 0; axis < 3; axis++) turn += cross(from.axes.column[axis], to.axes.column[axis]) * 0.5;
  return -0.5 * dot(force_sum, to.position - from.position) - 0.5 * dot(torque_sum, turn);
}

}  // namespace turgor::contact
