// Tracks: where a needle enters, how the crack grows, and which of its points are on the shaft.
#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/contact/first_stop.hpp"
#include "turgor/contact/needle_tick.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/geometry/triangle_point.hpp"

namespace turgor::contact {

namespace {

/// Stores the column and the row of C that belong to one point.
void fill_compliance_of(const NeedleTick& tick, std::size_t point) {
  NeedleTrack& track = tick.track();
  const std::size_t stride = compliance_stride(track);
  sfem::compliance_row(tick.inner, track.points[point].at, tick.state.row);
  for (std::size_t i = 0; i < track.points.size(); i++) {
    const sfem::ComplianceBlock block =
        sfem::compliance_in_row(tick.inner, tick.state.row, track.points[i].at);
    for (std::size_t k = 0; k < 9; k++) {
      track.compliance[(3 * i + k / 3) * stride + 3 * point + k % 3] = float(block[k]);
      track.compliance[(3 * point + k % 3) * stride + 3 * i + k / 3] = float(block[k]);
    }
  }
}

/// Displacement of the corners of an element by the present forces and without them.
std::array<Vec3d, 10> displaced_corners(const NeedleTick& tick, int element) {
  // forces on vertices
  const NeedleTrack& track = tick.track();
  std::fill(tick.state.force_on_vertex.begin(), tick.state.force_on_vertex.end(), Vec3d{});
  add_needle_forces(tick.inner, tick.state, tick.state.force_on_vertex);
  std::array<Vec3d, 10> u = sfem::corner_displacements(tick.inner, element, tick.state.force_on_vertex);
  // motion without the needle
  TURGOR_CHECK(!track.points.empty(), "a track in use has an end");
  const auto corners = std::size_t(tick.inner.corners);
  for (std::size_t c = 0; c < corners && !tick.free.empty(); c++)
    u[c] += tick.free[std::size_t(tick.inner.corner[std::size_t(element) * corners + c])];
  return u;
}

/// Appends a point at the end of the crack, without force: it sticks where it is.
void add_point(const NeedleTick& tick) {
  NeedleTrack& track = tick.track();
  const std::size_t n = track.points.size();
  if (n >= track.force.size()) return;
  NeedlePoint point = track.points[0];
  point.arc = track.length, point.engaged = 0, point.stick = 0, point.along = tick.t();
  track.points.push_back(point);
  track.force[n] = track.before[n] = {};
  const Vec3d x = position(tick.state, 0);
  for (std::size_t axis = 0; axis < 3; axis++) {
    tick.state.x[3 * n + axis] = x[int(axis)];
    tick.state.force_on[3 * n + axis] = 0;
  }
  fill_compliance_of(tick, n);
}

constexpr double kOutside = 1e-3;  // distance outside of an element that counts as outside, of its size

/// True if a position at rest just outside of the element is beyond the body's surface, not only beyond the
/// elements whose Green's functions are known.
bool is_beyond_surface(const sfem::InnerGreen& inner, Vec3d rest, int element) {
  const double near = 5 * kOutside * inner.size[std::size_t(element)];
  return std::any_of(inner.surface.begin(), inner.surface.end(), [&](Int3 triangle) {
    const auto x = [&](int v) { return inner.x[std::size_t(v)]; };
    return nearest_on_triangle(rest, x(triangle.x), x(triangle.y), x(triangle.z)).distance < near;
  });
}

/// Share of the path of a crack from its end to a position at rest that nothing stops. The far surface and
/// tougher tissue do; where Green's functions end, the track is through.
double free_share(const NeedleTick& tick, const NeedlePoint& end, Vec3d to) {
  constexpr int kHalvings = 20;
  NeedleTrack& track = tick.track();
  const double toughness = toughness_at(tick, end.at);
  bool leaves = false;
  int element = end.at.element;  // of the last free position
  const auto is_free = [&](double share) {
    double outside = 0;
    const sfem::InnerPoint at =
        sfem::inner_point(tick.inner, end.rest + (to - end.rest) * share, end.at.element, outside);
    leaves = outside > kOutside;
    const bool is = !leaves && toughness_at(tick, at) <= toughness;
    if (is) element = at.element;
    return is;
  };
  const auto stop = first_stop(norm(to - end.rest), tick.needle.spacing / 4, is_free);
  if (!stop) return 1;
  // tougher tissue itself holds the tip; of the surface, the last position inside
  const PathStop at = refined(*stop, kHalvings, is_free);
  if (leaves && !is_beyond_surface(tick.inner, end.rest + (to - end.rest) * at.stopped, element)) {
    track.is_through = tick.state.beyond = true, track.force[0] = {};
    return 1;
  }
  track.is_at_exit = leaves;
  return leaves ? at.free : at.stopped;
}

}  // namespace

Vec3d position(const NeedleState& state, std::size_t point) {
  return {state.x[3 * point], state.x[3 * point + 1], state.x[3 * point + 2]};
}

int begin_track(const NeedleTick& tick, const sfem::InnerPoint& at, Vec3d rest) {
  NeedleState& state = tick.state;
  state.track = int(next_track(state.tracks));
  // its end is its entry
  NeedleTrack& track = tick.track();
  track.points.assign(
      1,
      NeedlePoint{.at = at, .rest = rest, .along = tick.t(), .unresolved = unresolved_compliance(tick, at)});
  track.force[0] = {};
  track.length = 0, track.entry = rest, track.is_at_exit = track.is_through = false,
  track.order = ++state.tracks_made, track.offset = {};
  fill_compliance_of(tick, 0);
  return state.track;
}

double toughness_at(const NeedleTick& tick, const sfem::InnerPoint& at) {
  const double own = tick.inner.toughness.empty() ? -1 : tick.inner.toughness[std::size_t(at.element)];
  return own >= 0 ? own : tick.needle.toughness;
}

double cut_to_tip(const NeedleTick& tick, double ahead) {
  NeedleTrack& track = tick.track();
  NeedlePoint& end = track.points[0];
  // new material point at the tip, X = p − u(X), by a few fixed-point steps from X + ahead
  const NeedlePoint before = end;
  const Vec3d goal = tick.bends() ? cut_position(tick, ahead) : tick.pose.position;
  const double most = 2 * ahead + 1e-4;
  Vec3d rest = before.rest + tick.t() * ahead;
  double outside = 0;
  int element = -1;
  std::array<Vec3d, 10> corners{};
  for (int pass = 0; pass < 4; pass++) {
    const sfem::InnerPoint at = sfem::inner_point(tick.inner, rest, before.at.element, outside);
    if (at.element != element) corners = displaced_corners(tick, element = at.element);
    Vec3d next = goal;
    for (std::size_t c = 0; c < std::size_t(tick.inner.corners); c++) next -= corners[c] * at.weight[c];
    const Vec3d step = next - before.rest;
    rest = norm(step) > most ? before.rest + step * (most / norm(step)) : next;
  }
  // the far surface and tougher tissue stop it
  const double share = free_share(tick, before, rest);
  rest = before.rest + (rest - before.rest) * share;
  const sfem::InnerPoint at = sfem::inner_point(tick.inner, rest, before.at.element, outside);
  // energy of moving the tip's force from the old end to the new one: ½ F (C_nn − C_no − C_on + C_oo) F
  const sfem::ComplianceBlock nn = sfem::compliance_between(tick.inner, at, at),
                              no = sfem::compliance_between(tick.inner, at, before.at),
                              oo = sfem::compliance_between(tick.inner, before.at, before.at);
  const Vec3d f = track.force[0];
  double energy = 0;
  for (int j = 0; j < 3; j++)
    for (int i = 0; i < 3; i++) {
      const auto k = std::size_t(3 * j + i), transposed = std::size_t(3 * i + j);
      energy += 0.5 * f[i] * f[j] * (nn[k] - no[k] - no[transposed] + oo[k]);
    }
  tick.state.work.cutting += tick.stiffness * energy;
  // the new end, and points at the middle of every cell of the track
  track.length += norm(rest - before.rest);
  end.at = at, end.rest = rest, end.arc = track.length, end.unresolved = unresolved_compliance(tick, at);
  fill_compliance_of(tick, 0);
  const Vec3d x = position(tick.state, 0);
  for (int axis = 0; axis < 3; axis++)
    tick.state.x[std::size_t(axis)] = x[axis] + share * (goal[axis] - x[axis]);
  const auto cells = std::size_t(std::floor(track.length / tick.needle.spacing + 0.5));
  while (track.points.size() - 1 < cells && track.points.size() < track.force.size()) add_point(tick);
  return share;
}

double inserted_length(const NeedleTick& tick) {
  const Vec3d p = tick.pose.position, t = tick.t();
  return inserted_length(tick.track(), [&](std::size_t i) { return dot(position(tick.state, i) - p, t); });
}

SurfaceHit first_surface_hit(const NeedleTick& tick, Vec3d from, Vec3d to) {
  SurfaceHit hit;
  constexpr double kEdge = 1e-9;  // a tip on an edge or a vertex meets one of its triangles
  const Vec3d d = to - from;
  const auto now = [&](int v) {
    const auto i = std::size_t(v);
    return tick.free.empty() ? tick.inner.x[i] : tick.inner.x[i] + tick.free[i];
  };
  for (std::size_t s = 0; s < tick.inner.surface.size(); s++) {
    // Möller and Trumbore 1997; only from outside
    const Int3 corners = tick.inner.surface[s];
    const Vec3d a = now(corners.x), ab = now(corners.y) - a, ac = now(corners.z) - a, q = cross(d, ac);
    const double det = dot(ab, q);
    if (!(dot(cross(ab, ac), d) < 0) || det == 0) continue;
    const Vec3d r = from - a, n = cross(r, ab);
    const double u = dot(r, q) / det, v = dot(d, n) / det, fraction = dot(ac, n) / det;
    if (u < -kEdge || v < -kEdge || u + v > 1 + kEdge || fraction < 0 || fraction > 1 ||
        fraction >= hit.fraction)
      continue;
    // the nearest one so far
    const auto x = [&](int i) { return tick.inner.x[std::size_t(i)]; };
    hit.fraction = fraction, hit.now = from + d * fraction;
    hit.rest = x(corners.x) * (1 - u - v) + x(corners.y) * u + x(corners.z) * v;
    double outside = 0;
    hit.at = sfem::inner_point(tick.inner, hit.rest, tick.inner.behind[s], outside);
  }
  return hit;
}

int track_entered_at(const NeedleTick& tick, Vec3d x) {
  int best = -1;
  double nearest = tick.needle.diameter;
  for (std::size_t i = 0; i < tick.state.tracks.size(); i++) {
    const NeedleTrack& track = tick.state.tracks[i];
    if (track.points.empty() || track.length == 0) continue;
    double outside = 0;
    const sfem::InnerPoint at = sfem::inner_point(tick.inner, track.entry, -1, outside);
    const Vec3d entry =
        tick.free.empty() ? track.entry : track.entry + sfem::at_point(tick.inner, at, tick.free);
    if (const double d = norm(entry - x); d < nearest) nearest = d, best = int(i);
  }
  return best;
}

}  // namespace turgor::contact
