#include "turgor/contact/needle_touch.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/contact/needle_tick.hpp"
#include "turgor/contact/tool.hpp"
#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

constexpr double kSurface =
    2e-4;  // a tip looks for the surface from this far behind it, because the surface may move [m]

/// Takes the needle out of the body; its tracks stay.
void leave(NeedleState& state) {
  NeedleTrack& track = state.tracks[std::size_t(state.track)];
  for (std::size_t i = 0; i < track.points.size(); i++) track.points[i].engaged = 0, track.force[i] = {};
  if (track.length == 0) track.points.clear();
  state.phase = NeedlePhase::kOutside, state.inserted = 0, state.tip_force = 0, state.beam = {};
}

/// Force F of the tip; rounding at its lower bound is removed, also that of a force across the shaft.
double tip_force(const NeedleTick& tick, double tearing) {
  constexpr double kRounding = 1e-12;
  const Vec3d along = tick.along(0), whole = tick.track().force[0];
  const double share = tick.bends() ? dot(along, along) : 1;
  const double force = tick.stiffness * dot(whole, along) / share;
  return force > kRounding * std::max(tearing, tick.stiffness * norm(whole)) ? force : 0;
}

/// Displacement of a point by the body's motion without this needle [m].
Vec3d free_displacement(const NeedleTick& tick, std::size_t i) {
  return tick.free.empty() ? Vec3d{} : sfem::at_point(tick.inner, tick.track().points[i].at, tick.free);
}

/// Forces of the points, of a shaft that is rigid or bends.
void solve_shaft(const NeedleTick& tick, double tearing) {
  tick.bends() ? solve_bending_needle(tick, tearing) : solve_needle(tick, tearing);
}

/// Looks for the surface between the last tip and this one: an old track, or a new one of length 0.
void enter(const NeedleTick& tick) {
  NeedleState& state = tick.state;
  const SurfaceHit hit =
      first_surface_hit(tick, state.pose.position + state.pose.axes.column[2] * kSurface, tick.pose.position);
  if (hit.fraction > 1) return;
  state.inserted = 0;
  if (const int old = track_entered_at(tick, hit.now); old >= 0) {
    state.track = old, state.phase = NeedlePhase::kInside;
    return;
  }
  begin_track(tick, hit.at, hit.rest);
  state.phase = NeedlePhase::kTouching;
}

/// The tip on the surface, which it punctures at the surface's own toughness.
void touch_surface(const NeedleTick& tick) {
  NeedleState& state = tick.state;
  const double tearing = tearing_force(tick.needle, tick.needle.entry_toughness);
  solve_shaft(tick, tearing);
  state.tip_force = tip_force(tick, tearing);
  state.entry_force = state.punctures > 0 ? state.entry_force : std::max(state.entry_force, state.tip_force);
  if (state.tip_force >= tearing * (1 - 1e-9)) state.phase = NeedlePhase::kInside, state.punctures++;
  if (state.tip_force <= 0) leave(state);
}

/// Force F at which the crack grows [N].
double tearing_at_end(const NeedleTick& tick) {
  const NeedleTrack& track = tick.track();
  if (track.is_through) return 0;
  return tearing_force(
      tick.needle, track.is_at_exit ? tick.needle.exit_toughness : toughness_at(tick, track.points[0].at));
}

/// Material at the tip: that of the track's nearest point.
int material_at_tip(const NeedleTick& tick) {
  const NeedleTrack& track = tick.track();
  const auto nearest = std::size_t(std::max(0.0, tick.state.inserted) / tick.needle.spacing) + 1;
  const NeedlePoint& point = track.points[nearest < track.points.size() ? nearest : 0];
  return tick.inner.material[std::size_t(point.at.element)];
}

/// Forces once more, after the end of the crack has changed in this tick.
void solve_again(const NeedleTick& tick) {
  const double tearing = tearing_at_end(tick);
  find_positions(tick);
  solve_shaft(tick, tearing);
  tick.state.work.friction += tick.stiffness * follow_slip(tick);
  tick.state.tip_force = tick.track().is_through ? 0 : tip_force(tick, tearing);
}

/// The tip, which is `apart` beyond the end of the crack, meets what stopped it there.
void meet_tougher(const NeedleTick& tick, double apart) {
  const double before = tick.state.tip_force;
  solve_again(tick);
  tick.state.work.cutting -= 0.5 * (before + tick.state.tip_force) * apart;
}

/// The tip tears the far surface, which springs back along the shaft.
void tear_exit(const NeedleTick& tick) {
  NeedleTrack& track = tick.track();
  const Vec3d before = track.before[0];
  track.is_at_exit = false, track.is_through = true, track.force[0] = {};
  solve_again(tick);
  const Vec3d apart = tick.tip() - position(tick.state, 0);
  tick.state.work.cutting += 0.5 * tick.stiffness * dot(before, apart);
}

/// The tip in its track: forces, slip along the shaft, and the crack's growth.
void advance_inside(const NeedleTick& tick) {
  NeedleState& state = tick.state;
  NeedleTrack& track = tick.track();
  const double tearing = tearing_at_end(tick);
  solve_shaft(tick, tearing);
  state.work.friction += tick.stiffness * follow_slip(tick);
  // growth of the crack; after a puncture the force drops, and the spread crack takes its energy from it
  const double before = state.tip_force, spread = spreading_force(tick), stored = spreading_energy(tick);
  double growth = 0;
  state.tip_force = track.is_through ? 0 : tip_force(tick, tearing);
  const double ahead = -dot(position(state, 0) - tick.pose.position, tick.t());
  if (!track.is_through && ahead > 0 && state.tip_force >= tearing * (1 - 1e-9)) {
    if (track.is_at_exit) {
      tear_exit(tick);
    } else {
      state.work.cutting += 0.5 * (std::max(before, state.tip_force) + state.tip_force) * ahead;
      growth = ahead * cut_to_tip(tick, ahead);
      if (growth < ahead) meet_tougher(tick, ahead - growth);
    }
  }
  // points on the shaft
  state.inserted = inserted_length(tick);
  state.work.friction += tick.stiffness * engage(tick, state.inserted);
  if (growth > 0) state.work.cutting -= spreading_energy(tick) - stored - spread * growth;
  if (state.inserted <= 0 && state.tip_force <= 0) leave(state);
}

/// Force and torque on the needle, from the points of the track in use.
void sum_needle_forces(const NeedleTick& tick) {
  NeedleState& state = tick.state;
  state.force = state.torque = {}, state.reading = {};
  if (state.phase == NeedlePhase::kOutside) return;
  const NeedleTrack& track = tick.track();
  const Vec3d t = tick.t();
  for (std::size_t i = 0; i < track.points.size(); i++) {
    const Vec3d f =
        Vec3d{state.force_on[3 * i], state.force_on[3 * i + 1], state.force_on[3 * i + 2]} * tick.stiffness;
    state.force -= f;
    state.torque -= cross(arm_on_shaft(tick, i), f);
    if (i > 0) state.reading.friction += tick.stiffness * dot(track.force[i], t);
  }
  state.reading.deflection = tick.tip() - tick.pose.position;
  state.reading.inserted = std::max(0.0, state.inserted);
  state.reading.cutting = state.tip_force;
  state.reading.material = material_at_tip(tick);
  state.reading.spreading = spreading_force(tick);
}

/// Half of the work that the present forces do on the motion of the body by everything but this needle, since
/// the last tick [J]. Points that are new in this tick have none.
double half_work_on_others(const NeedleTick& tick) {
  double work = 0;
  const std::size_t n = std::min(tick.state.carried_points, tick.track().points.size());
  for (std::size_t i = 0; i < n; i++) {
    const Vec3d f{tick.state.force_on[3 * i], tick.state.force_on[3 * i + 1], tick.state.force_on[3 * i + 2]};
    work += 0.5 * dot(f, tick.state.carried_by[i]);
  }
  return tick.stiffness * work;
}

/// Sets the displacements of all points by the rest of the body since the last tick; without free motion they
/// are zero.
void find_carried(const NeedleTick& tick) {
  NeedleState& state = tick.state;
  TURGOR_CHECK(state.carried_points <= tick.track().points.size(), "a track keeps its points between ticks");
  for (std::size_t i = 0; i < state.carried_points; i++)
    state.carried_by[i] = free_displacement(tick, i) - state.carried[i];
}

/// Keeps the displacements of the points by the rest of the body for the next tick.
void keep_carried(const NeedleTick& tick) {
  NeedleState& state = tick.state;
  state.carried_points = state.phase == NeedlePhase::kOutside ? 0 : tick.track().points.size();
  for (std::size_t i = 0; i < state.carried_points; i++) state.carried[i] = free_displacement(tick, i);
}

ToolReading reading_of(const NeedleTick& tick) {
  const NeedleState& state = tick.state;
  ToolReading reading{.force = state.force, .torque = state.torque};
  reading.beyond_patch = state.beyond;
  if (state.phase == NeedlePhase::kOutside) return reading;
  const NeedleTrack& track = tick.track();
  for (const Vec3d f : std::span(track.force).first(track.points.size())) reading.contacts += !(f == Vec3d{});
  reading.depth = std::max(0.0, dot(tick.pose.position - track.entry, tick.t()));
  return reading;
}

}  // namespace

NeedleState make_needle_state(const sfem::InnerGreen& inner, const Needle& needle) {
  NeedleState state;
  const auto most =
      std::size_t(std::clamp(std::ceil(needle.length / needle.spacing) + 2, 2.0, double(kMostNeedlePoints)));
  state.tracks.resize(kMostTracks);
  for (NeedleTrack& track : state.tracks) {
    track.points.reserve(most);
    track.force.resize(most), track.before.resize(most);
    track.compliance.resize(3 * most * whole_lines(3 * most));
  }
  state.x.resize(whole_lines(3 * most)), state.force_on.resize(3 * most);
  state.carried.resize(most), state.carried_by.resize(most);
  state.row.resize(9 * inner.vertices.size()), state.force_on_vertex.resize(inner.vertices.size());
  return state;
}

ToolReading tick_needle(const sfem::InnerGreen& inner, const Needle& needle, std::span<const Vec3d> free,
                        const Pose& pose, double stiffness, NeedleState& state) {
  TURGOR_CHECK(stiffness > 0 && (free.empty() || free.size() == inner.vertices.size()),
               "a needle is in a body with a stiffness");
  const NeedleTick tick{inner, needle, free, pose, stiffness, state};
  const bool is_usable = is_valid(pose) && !inner.elements.empty();
  // an invalid pose, or one far from the last
  if (!is_usable || !state.seen || norm(pose.position - state.pose.position) > kNeedleJump) {
    leave(state);
    state.force = state.torque = state.step = {}, state.reading = {}, state.seen = is_usable;
    state.carried_points = 0;
    if (is_usable) state.pose = pose;
    return {};
  }
  // contact, cutting
  const Vec3d force = state.force, torque = state.torque;
  find_carried(tick);
  state.work.others += half_work_on_others(tick);
  if (state.phase == NeedlePhase::kOutside) enter(tick);
  if (state.phase != NeedlePhase::kOutside) {
    extrapolate_forces(tick);
    find_positions(tick);
    state.phase == NeedlePhase::kTouching ? touch_surface(tick) : advance_inside(tick);
  }
  if (state.phase != NeedlePhase::kOutside) state.work.others += half_work_on_others(tick);
  keep_carried(tick);
  // forces and energies
  sum_needle_forces(tick);
  state.work.hand += hand_work(state.pose, pose, force + state.force, torque + state.torque);
  const bool is_out = state.phase == NeedlePhase::kOutside;
  state.work.spreading = is_out ? 0 : spreading_energy(tick);
  state.work.elastic = is_out ? 0 : stiffness * elastic_energy(tick);
  state.step = pose.position - state.pose.position, state.pose = pose;
  return reading_of(tick);
}

void add_needle_forces(const sfem::InnerGreen& inner, const NeedleState& state,
                       std::span<Vec3d> of_vertices) {
  if (state.phase == NeedlePhase::kOutside) return;
  const NeedleTrack& track = state.tracks[std::size_t(state.track)];
  for (std::size_t i = 0; i < track.points.size(); i++)
    sfem::add_force(inner, track.points[i].at,
                    {state.force_on[3 * i], state.force_on[3 * i + 1], state.force_on[3 * i + 2]},
                    of_vertices);
}

}  // namespace turgor::contact
