// Tracks of a needle in a lattice: where it enters, how the crack grows, and its points after a cut.
#include <algorithm>
#include <cmath>
#include <optional>

#include "turgor/contact/first_stop.hpp"
#include "turgor/contact/lattice_needle_step.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/cutting/embed_point.hpp"

namespace turgor::contact {

namespace {

using lattice::EmbeddedPoint;

std::optional<EmbeddedPoint> embed(const NeedleSurroundings& around, Vec3d rest) {
  return lattice::embed_point(around.model, around.state.cuts, around.fragments, rest);
}

/// Point of a track at a rest position.
LatticeNeedlePoint make_point(const NeedleSurroundings& around, const EmbeddedPoint& at, Vec3d rest,
                              double arc) {
  LatticeNeedlePoint point{.at = at, .rest = rest, .arc = arc, .tissue = around.tissue_at(rest)};
  point.x = position_of(around.state.motion, at, rest);
  return point;
}

/// Hit of a path on the present surface.
struct SkinHit {
  Vec3d rest, now;      // lattice frame, and patient frame [m]
  double fraction = 2;  // of the path; above 1 = none
};
/// First hit between two positions in the patient frame (Möller and Trumbore 1997).
SkinHit first_hit(const NeedleSurroundings& around, Vec3d from, Vec3d to) {
  constexpr double kFarthest = 0.05;  // displacement of skin that is found [m]
  constexpr double kEdge = 1e-9;      // a tip on an edge meets one of its triangles
  const Grid& grid = around.model.anatomy.grid;
  const lattice::BodySurface& surface = around.surface;
  const Mat3d to_lattice = inverse(grid.axes);
  const Vec3d middle = to_lattice * ((from + to) / 2 - grid.origin), d = to - from;
  const double reach = kFarthest + norm(d);
  SkinHit hit;
  for (const Int3 t : surface.triangles) {
    if (norm(Vec3d(surface.rest[std::size_t(t.x)]) - middle) > reach) continue;
    const auto now = [&](int v) {
      return grid.origin +
             grid.axes * (Vec3d(surface.rest[std::size_t(v)]) +
                          Vec3d(lattice::vertex_displacement(around.model, around.state, surface, v)));
    };
    const Vec3d a = now(t.x), ab = now(t.y) - a, ac = now(t.z) - a, q = cross(d, ac);
    const double det = dot(ab, q);
    if (det == 0) continue;
    const Vec3d r = from - a, n = cross(r, ab);
    const double u = dot(r, q) / det, v = dot(d, n) / det, fraction = dot(ac, n) / det;
    const bool is_inside = u >= -kEdge && v >= -kEdge && u + v <= 1 + kEdge;
    if (!is_inside || fraction < 0 || fraction > 1 || fraction >= hit.fraction) continue;
    const auto rest = [&](int i) { return Vec3d(surface.rest[std::size_t(i)]); };
    hit = {rest(t.x) * (1 - u - v) + rest(t.y) * u + rest(t.z) * v, from + d * fraction, fraction};
  }
  return hit;
}

/// Track whose entry is within a needle's diameter of a position in the lattice frame; -1 = none.
int old_track_at(const NeedleSurroundings& around, const Needle& needle, const LatticeNeedle& state,
                 Vec3d position) {
  int best = -1;
  double nearest = needle.diameter;
  for (std::size_t i = 0; i < state.tracks.size(); i++) {
    const LatticeNeedleTrack& track = state.tracks[i];
    if (track.points.empty() || track.length == 0) continue;
    const double d = norm(position_of(around.state.motion, track.entry_at, track.entry) - position);
    if (d < nearest) nearest = d, best = int(i);
  }
  return best;
}

/// Share of the path of a crack from its end to a position at rest that nothing stops: the far surface and
/// tougher tissue do.
struct FreeWay {
  double share = 1;
  bool leaves = false;  // the body stops it
};
FreeWay free_way(const NeedleSurroundings& around, const Needle& needle, const LatticeNeedlePoint& end,
                 Vec3d to) {
  constexpr int kHalvings = 12;
  const auto toughness = [&](const NeedleTissue& of) {
    return of.toughness >= 0 ? of.toughness : needle.toughness;
  };
  bool leaves = false;
  const auto is_free = [&](double share) {
    const Vec3d rest = end.rest + (to - end.rest) * share;
    leaves = !embed(around, rest);
    return !leaves && toughness(around.tissue_at(rest)) <= toughness(end.tissue);
  };
  const auto stop = first_stop(norm(to - end.rest), needle.spacing / 4, is_free);
  if (!stop) return {};
  // tougher tissue itself holds the tip; of the surface, the last position inside
  const PathStop at = refined(*stop, kHalvings, is_free);
  return {leaves ? at.free : at.stopped, leaves};
}

/// Appends points at the middle of every cell of the track that its new part contains.
void add_points(const NeedleSurroundings& around, const Needle& needle, const LatticeNeedlePoint& before,
                LatticeNeedleTrack& track) {
  const LatticeNeedlePoint end = track.points[0];
  const auto most =
      std::size_t(std::clamp(std::ceil(needle.length / needle.spacing) + 2, 2.0, double(kMostNeedlePoints)));
  const auto cells = std::size_t(std::floor(track.length / needle.spacing + 0.5));
  while (track.points.size() - 1 < cells && track.points.size() < most) {
    const double arc = (double(track.points.size()) - 0.5) * needle.spacing;
    const double share = std::clamp((arc - before.arc) / (end.arc - before.arc), 0.0, 1.0);
    const Vec3d rest = before.rest + (end.rest - before.rest) * share;
    track.points.push_back(make_point(around, embed(around, rest).value_or(end.at), rest, arc));
  }
}

}  // namespace

NeedleAxis axis_in_lattice(const lattice::Model& model, const Pose& pose) {
  const Mat3d to_lattice = inverse(model.anatomy.grid.axes);
  return {to_lattice * (pose.position - model.anatomy.grid.origin),
          to_lattice * (pose.axes.column[2] * -1.0)};
}

Vec3d position_of(const lattice::Motion& motion, const EmbeddedPoint& at, Vec3d rest) {
  return rest + Vec3d(displacement(at, motion));
}

void find_entry(const NeedleSurroundings& around, const Needle& needle, Vec3d from, Vec3d to,
                LatticeNeedle& state) {
  const SkinHit hit = first_hit(around, from, to);
  if (hit.fraction > 1) return;
  const Grid& grid = around.model.anatomy.grid;
  const Vec3d now = inverse(grid.axes) * (hit.now - grid.origin);
  state.inserted = 0;
  if (const int old = old_track_at(around, needle, state, now); old >= 0) {
    state.track = old, state.phase = NeedlePhase::kInside;
    for (LatticeNeedlePoint& point : track_of(state).points)
      point.x = position_of(around.state.motion, point.at, point.rest);
    return;
  }
  const std::optional<EmbeddedPoint> at = embed(around, hit.rest);
  if (!at) return;
  state.track = int(next_track(state.tracks)), state.phase = NeedlePhase::kTouching;
  track_of(state) = {.points = {make_point(around, *at, hit.rest, 0)},
                     .entry_at = *at,
                     .entry = hit.rest,
                     .order = ++state.tracks_made};
}

double cut_to_tip(const NeedleSurroundings& around, const Needle& needle, double ahead,
                  LatticeNeedle& state) {
  LatticeNeedleTrack& track = track_of(state);
  const LatticeNeedlePoint before = track.points[0];
  const NeedleAxis axis = axis_in_lattice(around.model, state.pose);
  // new material point at the tip, X = p − u(X), by a few fixed-point steps
  const double most = 2 * ahead + 1e-4;
  Vec3d rest = before.rest + axis.t * ahead;
  std::optional<EmbeddedPoint> at;
  for (int pass = 0; pass < 4; pass++) {
    at = embed(around, rest);
    if (!at) break;
    const Vec3d step = axis.tip - Vec3d(displacement(*at, around.state.motion)) - before.rest;
    rest = before.rest + step * std::min(1.0, most / std::max(norm(step), 1e-12));
  }
  // the far surface and tougher tissue stop it
  const FreeWay free = free_way(around, needle, before, rest);
  rest = before.rest + (rest - before.rest) * free.share;
  at = embed(around, rest);
  track.is_at_exit = free.leaves;
  // the new end keeps the force of the tip
  track.length += norm(rest - before.rest);
  LatticeNeedlePoint end = make_point(around, at.value_or(before.at), rest, track.length);
  end.force = before.force;
  end.spread = before.spread, end.load = before.load, end.is_coupled = before.is_coupled;
  track.points[0] = end;
  if (track.length > before.arc) add_points(around, needle, before, track);
  return free.share;
}

void embed_tracks(const NeedleSurroundings& around, LatticeNeedle& state) {
  const std::size_t version = lattice::cut_version(around.state.cuts);
  if (state.cuts == version) return;
  state.cuts = version;
  for (LatticeNeedleTrack& track : state.tracks) {
    // tracks in tissue that was removed
    bool is_kept = true;
    for (LatticeNeedlePoint& point : track.points) {
      const std::optional<EmbeddedPoint> at = embed(around, point.rest);
      if (at) point.at = *at;
      is_kept = is_kept && at;
    }
    if (const std::optional<EmbeddedPoint> at = embed(around, track.entry)) track.entry_at = *at;
    if (is_kept) continue;
    if (&track == &track_of(state)) release_needle(state);
    track = {};
  }
}

}  // namespace turgor::contact
