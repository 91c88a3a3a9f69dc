// Springs of a needle's points in a lattice, and their forces.
#include <algorithm>
#include <cmath>
#include <limits>

#include "turgor/contact/lattice_needle_step.hpp"
#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

/// Penalty stiffness k of the tip, in multiples of Young's modulus times the spacing. A multiplier that
/// builds up in small steps and is released in one gains up to F²/2k for the hand. 12 would halve that, but
/// sweeps do not converge at 0.8 mm a frame, so that the force of a tip on the surface falls before it
/// punctures.
constexpr double kTipStiffness = 6;

/// Mean spacing of a lattice [m].
double mean_spacing(const lattice::Model& model) {
  const Vec3d h(model.anatomy.lattice.spacing);
  return std::cbrt(h.x * h.y * h.z);
}

/// Young's modulus around a point; cut cells have that of fat at least [Pa].
double young_at(const lattice::Model& model, const LatticeNeedlePoint& point) {
  const double young = double(model.anatomy.cell_young[std::size_t(point.at.cell)]);
  return young > 0 ? young : model.params.tissue.fat;
}

/// ln of the radius that the cells resolve, as in needle_solve.cpp: ln r₀/h = c − 3.75 Σ w². A point beyond
/// its cell is taken as one at a node.
double log_resolved(const lattice::Model& model, const LatticeNeedlePoint& point) {
  constexpr double kConcentrated = 3.75, kCells = 0.27;
  double squares = 0;
  for (const Real w : point.at.weight) squares += double(w) * double(w);
  return kCells - kConcentrated * std::min(1.0, squares) + std::log(mean_spacing(model));
}

/// True if no corner of a point can move: bone, and fixed tissue.
bool is_rigid(const lattice::Model& model, const LatticeNeedlePoint& point) {
  const std::size_t slots = model.anatomy.inverse_mass.size();
  return std::all_of(point.at.corner.begin(), point.at.corner.end(), [&](int corner) {
    return std::size_t(corner) < slots && !(model.anatomy.inverse_mass[std::size_t(corner)] > 0);
  });
}

/// Spring that has the force λ + s at the present displacement, and these stiffnesses around it.
void set_spring(const lattice::Motion& motion, const NeedleAxis& axis, const LatticeNeedlePoint& point,
                double along, double across, lattice::PointSpring& spring) {
  spring.target = displacement(point.at, motion);
  spring.force = Vec3(point.force + point.spread);
  spring.stiffness = lattice::axial_stiffness(Vec3(axis.t), Real(along), Real(across));
}

/// λ of the tip: multiplier and penalty.
void update_tip(const lattice::Model& model, const lattice::Motion& motion, const NeedleAxis& axis,
                double tearing, LatticeNeedlePoint& point, lattice::PointSpring& spring) {
  const double penalty = kTipStiffness * young_at(model, point) * mean_spacing(model);
  const Vec3d trial = point.multiplier + (axis.tip - position_of(motion, point.at, point.rest)) * penalty;
  const double along = dot(trial, axis.t), bounded = std::clamp(along, 0.0, tearing);
  point.force = trial + axis.t * (bounded - along);
  set_spring(motion, axis, point, bounded == along ? penalty : 0, penalty, spring);
}

/// λ of a point of the shaft.
void update_shaft_point(const lattice::Model& model, const lattice::Motion& motion, const Needle& needle,
                        const NeedleAxis& axis, LatticeNeedlePoint& point, lattice::PointSpring& spring) {
  const OwnCompliance own = own_compliance(model, needle, point);
  TURGOR_CHECK(own.along > 0 && own.across > 0, "a coupled point stands for a length of the shaft");
  const Vec3d apart = axis.tip - position_of(motion, point.at, point.rest);
  const double ahead = dot(apart, axis.t), bound = friction_bound(needle, point);
  const double trial = (point.stick + ahead) / own.along, along = std::clamp(trial, -bound, bound);
  point.force = axis.t * along + (apart - axis.t * ahead) / own.across;
  set_spring(motion, axis, point, along == trial ? 1 / own.along : 0, 1 / own.across, spring);
}

}  // namespace

OwnCompliance own_compliance(const lattice::Model& model, const Needle& needle,
                             const LatticeNeedlePoint& point) {
  const double poisson = model.params.tissue.poisson, shear = young_at(model, point) / (2 * (1 + poisson));
  return own_compliance(needle, point.engaged, log_resolved(model, point), shear, poisson);
}

double friction_bound(const Needle& needle, const LatticeNeedlePoint& point) {
  return (point.tissue.friction >= 0 ? point.tissue.friction : needle.friction) * point.engaged;
}

double tearing_inside(const Needle& needle, const LatticeNeedle& state) {
  const NeedleTissue& tissue = track_of(state).points[0].tissue;
  return tearing_force(needle, tissue.toughness >= 0 ? tissue.toughness : needle.toughness);
}

double tearing_force(const Needle& needle, const LatticeNeedle& state) {
  if (track_of(state).is_through) return 0;
  if (track_of(state).is_at_exit) return tearing_force(needle, needle.exit_toughness);
  const double inside = tearing_inside(needle, state);
  if (state.phase != NeedlePhase::kTouching || std::isinf(inside)) return inside;
  return tearing_force(needle, needle.entry_toughness);
}

double position_on_shaft(const lattice::Model& model, const Needle& needle, const NeedleAxis& axis,
                         const LatticeNeedlePoint& point) {
  return dot(point.x - axis.tip, axis.t) +
         own_compliance(model, needle, point).along * dot(point.force, axis.t);
}

InsertedShaft shaft_of(const LatticeNeedle& state) {
  const LatticeNeedleTrack& track = track_of(state);
  return {state.inserted, track.is_through ? std::max(0.0, state.inserted - track.length) : 0};
}

void choose_springs(const lattice::Model& model, const Needle& needle, LatticeNeedle& state) {
  LatticeNeedleTrack& track = track_of(state);
  const NeedleAxis axis = axis_in_lattice(model, state.pose);
  // points on the shaft, and the end of the crack if the tip may reach it in this step
  for (LatticeNeedlePoint& point : track.points) {
    const bool is_end = &point == &track.points[0];
    const double ahead = dot(point.x - axis.tip, axis.t);
    const bool is_near = tearing_force(needle, state) > 0 && ahead < needle.spacing;
    point.is_coupled = is_end ? is_near : point.engaged > 1e-6 * needle.spacing;
    if (!point.is_coupled) point.force = {};
    // the multiplier of the tip; rigid tissue has the penalty only, since no force moves it
    point.multiplier = is_end && !is_rigid(model, point) ? point.force : Vec3d{};
    point.spread = {};
  }
  // load of the spread crack
  if (state.phase == NeedlePhase::kInside)
    if (const double load = spreading_force(needle, shaft_of(state)); load > 0) {
      const SpreadPoints at = spread_points(track.points, state.inserted, needle.spacing);
      if (at.before != at.next) track.points[at.before].spread += axis.t * (load * (1 - at.share));
      track.points[at.next].spread += axis.t * (load * at.share);
    }
  for (LatticeNeedlePoint& point : track.points)
    point.is_sprung = point.is_coupled || !(point.spread == Vec3d{});
}

void append_needle_springs(const LatticeNeedle& state, std::vector<lattice::PointSpring>& springs) {
  if (state.phase == NeedlePhase::kOutside) return;
  for (const LatticeNeedlePoint& point : track_of(state).points)
    if (point.is_sprung) springs.push_back({.at = point.at, .force = Vec3(point.force + point.spread)});
}

std::size_t update_needle_springs(const lattice::Model& model, const lattice::Motion& motion,
                                  const Needle& needle, LatticeNeedle& state,
                                  std::span<lattice::PointSpring> springs) {
  if (state.phase == NeedlePhase::kOutside) return 0;
  const NeedleAxis axis = axis_in_lattice(model, state.pose);
  const double tearing = tearing_force(needle, state);
  std::size_t next = 0;
  std::vector<LatticeNeedlePoint>& points = track_of(state).points;
  for (std::size_t i = 0; i < points.size(); i++) {
    if (!points[i].is_sprung) continue;
    TURGOR_CHECK(next < springs.size(), "every point with a spring has one of the step's springs");
    lattice::PointSpring& spring = springs[next++];
    if (!points[i].is_coupled)
      set_spring(motion, axis, points[i], 0, 0, spring);
    else if (i == 0)
      update_tip(model, motion, axis, tearing, points[i], spring);
    else
      update_shaft_point(model, motion, needle, axis, points[i], spring);
  }
  return next;
}

}  // namespace turgor::contact
