#include "turgor/contact/lattice_needle.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "turgor/contact/lattice_needle_step.hpp"
#include "turgor/contact/tool.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/cutting/fragments.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::contact {

namespace {

/// A tip looks for the surface from this far behind it, because the surface may move [m].
constexpr double kSurfaceMargin = 1e-3;

/// Largest force that a needle can bear along itself [N].
double resistance_of(const Needle& needle, const LatticeNeedle& state) {
  double sum = spreading_force(needle, shaft_of(state));
  const double tearing = tearing_force(needle, state);
  if (track_of(state).points[0].is_coupled && !std::isinf(tearing)) sum += tearing;
  for (const LatticeNeedlePoint& point : track_of(state).points) sum += friction_bound(needle, point);
  return sum;
}

/// Positions and loads after the step, and the work that the body took in it. Returns the largest change of a
/// load [N].
double read_positions(const lattice::Motion& motion, LatticeNeedle& state) {
  double change = 0;
  for (LatticeNeedlePoint& point : track_of(state).points) {
    const Vec3d x = position_of(motion, point.at, point.rest), load = point.force + point.spread;
    state.given += 0.5 * dot(point.load + load, x - point.x);
    change = std::max(change, norm(load - point.load));
    point.x = x, point.load = load;
  }
  return change;
}

/// The tip on the surface, which it punctures at the surface's own toughness.
void press_surface(const Needle& needle, double ahead, LatticeNeedle& state) {
  const double tearing = tearing_force(needle, state);
  state.entry_force = state.punctures > 0 ? state.entry_force : std::max(state.entry_force, state.tip_force);
  if (state.tip_force >= tearing * (1 - 1e-9)) state.phase = NeedlePhase::kInside, state.punctures++;
  if (state.tip_force <= 0 && ahead > needle.diameter) release_needle(state);
}

/// Lets slipping points follow the shaft, and returns the work of friction [J].
double slip(const lattice::Model& model, const Needle& needle, const NeedleAxis& axis, LatticeNeedle& state) {
  double work = 0;
  for (LatticeNeedlePoint& point : track_of(state).points) {
    if (&point == &track_of(state).points[0] || !point.is_coupled) continue;
    const double force = dot(point.force, axis.t);
    if (std::abs(force) < friction_bound(needle, point) * (1 - 1e-9)) continue;
    const double at = position_on_shaft(model, needle, axis, point);
    work += force * (point.stick - at), point.stick = at;
  }
  return work;
}

/// Sets ℓ of every point for the inserted length. Returns the energy of D that changes with ℓ, which friction
/// gains or bears [J].
double engage_points(const lattice::Model& model, const Needle& needle, const NeedleAxis& axis,
                     LatticeNeedle& state) {
  double released = 0;
  std::vector<LatticeNeedlePoint>& points = track_of(state).points;
  for (std::size_t i = 1; i < points.size(); i++) {
    LatticeNeedlePoint& point = points[i];
    const double engaged = std::clamp(state.inserted - double(i - 1) * needle.spacing, 0.0, needle.spacing);
    if (engaged == point.engaged) continue;
    // a point that the tip reaches sticks where it is
    if (point.engaged == 0) point.force = {}, point.stick = dot(point.x - axis.tip, axis.t);
    // the point keeps its force, and η follows the change of D
    const OwnCompliance before = own_compliance(model, needle, point);
    point.engaged = engaged;
    const OwnCompliance after = own_compliance(model, needle, point);
    released += own_energy(before, point.force, axis.t) - own_energy(after, point.force, axis.t);
    point.stick += (after.along - before.along) * dot(point.force, axis.t);
    if (engaged == 0) point.force = {};
  }
  return -released;
}

/// The tip in its track: slip along the shaft, and growth of the crack.
void advance_in_track(const NeedleSurroundings& around, const Needle& needle, double force_before,
                      LatticeNeedle& state) {
  const NeedleAxis axis = axis_in_lattice(around.model, state.pose);
  LatticeNeedleTrack& track = track_of(state);
  state.work.friction += slip(around.model, needle, axis, state);
  // growth of the crack; after a puncture the force drops, and the spread crack takes its energy from it
  const double tearing = tearing_force(needle, state), spread = spreading_force(needle, shaft_of(state)),
               stored = spreading_energy(needle, shaft_of(state));
  const double ahead = dot(axis.tip - track.points[0].x, axis.t);
  double growth = 0;
  // an end that stopped the crack closes up to the tip; torn, it springs back
  const double stopped_at = std::exchange(track.gap, 0);
  if (stopped_at > 0) state.work.cutting -= 0.5 * (force_before + state.tip_force) * stopped_at;
  if (track.is_through) state.work.cutting += 0.5 * force_before * std::max(0.0, ahead);
  if (tearing > 0 && track.points[0].is_coupled && ahead > 0 && state.tip_force >= tearing * (1 - 1e-9)) {
    if (track.is_at_exit) {
      track.is_at_exit = false, track.is_through = true;
    } else {
      state.work.cutting += 0.5 * (std::max(force_before, state.tip_force) + state.tip_force) * ahead;
      growth = ahead * cut_to_tip(around, needle, ahead, state);
      track.gap = ahead - growth;
    }
  }
  // points on the shaft
  state.inserted =
      inserted_length(track, [&](std::size_t i) { return dot(track.points[i].x - axis.tip, axis.t); });
  state.work.friction += engage_points(around.model, needle, axis, state);
  if (growth > 0) state.work.cutting -= spreading_energy(needle, shaft_of(state)) - stored - spread * growth;
  if (state.inserted <= 0 && state.tip_force <= 0) release_needle(state);
}

/// Material at the tip: that of the track's nearest point.
int tip_material(const Needle& needle, const LatticeNeedle& state) {
  const std::vector<LatticeNeedlePoint>& points = track_of(state).points;
  const auto nearest = std::size_t(std::max(0.0, state.inserted) / needle.spacing) + 1;
  return points[nearest < points.size() ? nearest : 0].tissue.material;
}

/// Force and torque on the needle in the patient frame, and their parts along it.
void sum_shaft_forces(const lattice::Model& model, const Needle& needle, LatticeNeedle& state) {
  state.force = state.torque = {}, state.reading = {};
  if (state.phase == NeedlePhase::kOutside) return;
  const Mat3d& axes = model.anatomy.grid.axes;
  const NeedleAxis axis = axis_in_lattice(model, state.pose);
  const Vec3d t = state.pose.axes.column[2] * -1.0;
  const std::vector<LatticeNeedlePoint>& points = track_of(state).points;
  for (const LatticeNeedlePoint& point : points) {
    const Vec3d f = axes * point.load;
    state.force -= f;
    const double on_shaft = &point == &points[0] ? dot(point.x - axis.tip, axis.t)
                                                 : position_on_shaft(model, needle, axis, point);
    state.torque -= cross(t * on_shaft, f);
    if (&point != &points[0]) state.reading.friction += dot(point.force, axis.t);
  }
  state.reading.inserted = std::max(0.0, state.inserted);
  state.reading.cutting = state.tip_force;
  state.reading.material = tip_material(needle, state);
  if (state.phase == NeedlePhase::kInside) state.reading.spreading = spreading_force(needle, shaft_of(state));
}

/// Energy of the displacements D [J].
double unresolved_energy(const lattice::Model& model, const Needle& needle, const LatticeNeedle& state) {
  const NeedleAxis axis = axis_in_lattice(model, state.pose);
  double energy = 0;
  const std::vector<LatticeNeedlePoint>& points = track_of(state).points;
  for (std::size_t i = 1; i < points.size(); i++)
    energy += own_energy(own_compliance(model, needle, points[i]), points[i].force, axis.t);
  return energy;
}

}  // namespace

LatticeNeedle make_lattice_needle() {
  LatticeNeedle state;
  state.tracks.resize(kMostTracks);
  return state;
}

void release_needle(LatticeNeedle& state) {
  LatticeNeedleTrack& track = track_of(state);
  for (LatticeNeedlePoint& point : track.points) {
    point.engaged = 0, point.is_coupled = point.is_sprung = false;
    point.force = point.spread = point.load = {};
  }
  if (track.length == 0) track.points.clear();
  state.phase = NeedlePhase::kOutside, state.inserted = 0, state.tip_force = 0;
}

void begin_needle_step(const NeedleSurroundings& around, const Needle& needle, const Pose& to,
                       LatticeNeedle& state) {
  embed_tracks(around, state);
  // an invalid pose, or one far from the last
  const bool is_usable = is_valid(to);
  if (!is_usable || !state.seen || norm(to.position - state.pose.position) > kNeedleJump) {
    release_needle(state);
    state.force = state.torque = {}, state.seen = is_usable;
    state.before = state.pose = is_usable ? to : state.pose;
    return;
  }
  state.before = state.pose, state.pose = to;
  // surface
  const Vec3d up = to.axes.column[2], from = state.before.position;
  if (state.phase == NeedlePhase::kOutside && dot(to.position - from, up) < 0)
    find_entry(around, needle, from + up * kSurfaceMargin, to.position, state);
  if (state.phase != NeedlePhase::kOutside) choose_springs(around.model, needle, state);
}

void finish_needle_step(const NeedleSurroundings& around, const Needle& needle, LatticeNeedle& state) {
  const Vec3d force = state.force, torque = state.torque;
  state.settled = true;
  if (state.phase != NeedlePhase::kOutside) {
    constexpr double kSettled = 1e-4;  // change over the needle's resistance
    const NeedleAxis axis = axis_in_lattice(around.model, state.pose);
    const double before = state.tip_force, change = read_positions(around.state.motion, state);
    state.settled = norm(state.pose.position - state.before.position) == 0 &&
                    change <= kSettled * resistance_of(needle, state);
    state.tip_force = std::max(0.0, dot(track_of(state).points[0].force, axis.t));
    const double ahead = dot(track_of(state).points[0].x - axis.tip, axis.t);
    state.phase == NeedlePhase::kTouching ? press_surface(needle, ahead, state)
                                          : advance_in_track(around, needle, before, state);
  }
  // forces and energies
  sum_shaft_forces(around.model, needle, state);
  state.work.hand += hand_work(state.before, state.pose, force + state.force, torque + state.torque);
  const bool is_out = state.phase == NeedlePhase::kOutside;
  state.work.spreading = state.phase == NeedlePhase::kInside ? spreading_energy(needle, shaft_of(state)) : 0;
  state.work.elastic = state.given + (is_out ? 0 : unresolved_energy(around.model, needle, state));
}

lattice::StepReport step_with_needle(const Exec& exec, const lattice::Model& model, lattice::State& state,
                                     const lattice::BodySurface& surface, const Needle& needle,
                                     const Pose& to, lattice::Inputs inputs, double dt, LatticeNeedle& of,
                                     const std::function<NeedleTissue(Vec3d rest)>& tissue_at) {
  TURGOR_ASSERT(inputs.springs == nullptr, "a step with a needle has no other springs");
  const std::shared_ptr<const lattice::Fragments> fragments = lattice::fragments_of(model, state.cuts);
  const NeedleSurroundings around{model, state, surface, *fragments, tissue_at};
  const LatticeNeedle before = of;
  begin_needle_step(around, needle, to, of);
  lattice::PointSprings springs;
  append_needle_springs(of, springs.all);
  make_terms(springs);
  springs.settled = of.settled;
  springs.refresh = [&](const lattice::State& now) {
    update_needle_springs(model, now.motion, needle, of, springs.all);
  };
  if (!springs.all.empty()) inputs.springs = &springs;
  const lattice::StepReport report = lattice::step(exec, model, state, inputs, dt);
  if (report.finite)
    finish_needle_step(around, needle, of);
  else
    of = before;
  return report;
}

double needle_depth(const lattice::Model& model, const LatticeNeedle& state) {
  if (state.phase == NeedlePhase::kOutside) return 0;
  const NeedleAxis axis = axis_in_lattice(model, state.pose);
  return std::max(0.0, dot(axis.tip - track_of(state).entry, axis.t));
}

int bearing_points(const LatticeNeedle& state) {
  if (state.phase == NeedlePhase::kOutside) return 0;
  const std::vector<LatticeNeedlePoint>& points = track_of(state).points;
  return int(std::count_if(points.begin(), points.end(),
                           [](const LatticeNeedlePoint& point) { return !(point.force == Vec3d{}); }));
}

}  // namespace turgor::contact
