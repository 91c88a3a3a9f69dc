// Forces of a needle: block Gauss–Seidel in its own frame. Each block is solved exactly: two bilateral
// unknowns across the shaft, and one along it in a box.
#include <algorithm>
#include <cmath>
#include <utility>

#include "turgor/contact/needle_tick.hpp"
#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

constexpr int kMostSweeps = 80;
constexpr double kNeedleTolerance =
    3e-6;  // change of a force in a sweep, relative to the needle's resistance

/// Radius that the mesh resolves around a line force: ln r₀/h = c − 3.75 Σ w², with the weights w of a point
/// and the size h of its element. Fitted to needles in long blocks whose sides are held, where the
/// displacement is known; a force on one node is resolved least (docs/needle.md).
double log_of_resolved_radius(const sfem::InnerGreen& inner, const sfem::InnerPoint& at) {
  constexpr double kConcentrated = 3.75, kHexahedra = 0.27, kTetrahedra = 1.5, kQuadratic = 0.9;
  double squares = 0;
  for (std::size_t c = 0; c < std::size_t(inner.corners); c++) squares += at.weight[c] * at.weight[c];
  const double kind = inner.corners == 8 ? kHexahedra : inner.corners == 4 ? kTetrahedra : kQuadratic;
  return kind - kConcentrated * squares + std::log(inner.size[std::size_t(at.element)]);
}

/// D of a point along and across the shaft, for its length ℓ [m/N].
OwnCompliance own_compliance(const NeedlePoint& point) {
  if (!(point.engaged > 0)) return {};
  return {point.unresolved.along / point.engaged, point.unresolved.across / point.engaged};
}

/// Energy ½ λ D λ [J].
double own_energy(const NeedleTick& tick, std::size_t i) {
  if (i == 0 && !tick.bends()) return 0;
  OwnCompliance own = own_compliance(tick.track().points[i]);
  if (i > 0) return own_energy(own, tick.track().force[i], tick.along(i));
  own.along = 0;
  return own_energy(own, tick.track().force[0], normalized(tick.along(0)));
}

/// Spread crack: its load acts at the tip, between the two points next to it.
void add_spreading(const NeedleTick& tick, std::vector<double>& force) {
  NeedleState& state = tick.state;
  NeedleTrack& track = tick.track();
  const double inserted = state.inserted, along = spreading_force(tick) / tick.stiffness;
  if (!(along > 0)) return;
  const Vec3d f = tick.t() * along;
  const auto add = [&](std::size_t i, double w) {
    for (int axis = 0; axis < 3; axis++) force[3 * i + std::size_t(axis)] += w * f[axis];
  };
  // points before and behind the tip
  const SpreadPoints at = spread_points(track.points, inserted, tick.needle.spacing);
  if (at.before != at.next) add(at.before, 1 - at.share);
  add(at.next, at.share);
}

InsertedShaft shaft_of(const NeedleTick& tick) {
  const NeedleTrack& track = tick.track();
  return {tick.state.inserted, track.is_through ? tick.state.inserted - track.length : 0};
}

/// Unknowns of one point.
struct NeedleBlock {
  Mat3d inverse;          // of C + D in the needle's frame
  double across[4] = {};  // inverse of its block across the shaft
  Vec3d coupling;         // row of C + D along the shaft; x and y
  OwnCompliance own;
  double low = 0, high = 0;  // bounds of the force along t [N]
  double stick = 0;          // η [m]
  bool is_solved = false;
};

/// Frame of the needle with t as third axis.
Mat3d push_axes(const NeedleTick& tick) {
  const Mat3d& axes = tick.pose.axes;
  return {{axes.column[1], axes.column[0], -1.0 * axes.column[2]}};
}

NeedleBlock block_of(const NeedleTick& tick, const Mat3d& frame, std::size_t i, double tearing) {
  const NeedlePoint& point = tick.track().points[i];
  NeedleBlock block;
  const bool is_end = i == 0;
  block.is_solved = is_end ? tearing > 0 : point.engaged > 1e-6 * tick.needle.spacing;
  if (!block.is_solved) return block;
  if (!is_end) block.own = own_compliance(point);
  Mat3d a = transposed(frame) * own_block(tick.track(), i) * frame;
  a.column[0].x += block.own.across, a.column[1].y += block.own.across, a.column[2].z += block.own.along;
  block.inverse = inverse(a);
  const double det = a.column[0].x * a.column[1].y - a.column[1].x * a.column[0].y;
  block.across[0] = a.column[1].y / det, block.across[1] = -a.column[1].x / det;
  block.across[2] = -a.column[0].y / det, block.across[3] = a.column[0].x / det;
  block.coupling = {a.column[2].x, a.column[2].y, 0};
  const double bound = tick.needle.friction * point.engaged / tick.stiffness;
  block.low = is_end ? 0 : -bound, block.high = is_end ? tearing / tick.stiffness : bound;
  block.stick = is_end ? 0 : point.stick;
  return block;
}

/// Solves one point that has moved in this sweep; returns the change of its force, in the world.
Vec3d solve_block(const NeedleTick& tick, const Mat3d& frame, const NeedleBlock& block, std::size_t i,
                  Vec3d moved) {
  Vec3d& force = tick.track().force[i];
  const Vec3d now = transposed(frame) * force;
  // residual c = x + D λ − (p + η t)
  const Vec3d apart = transposed(frame) * (position(tick.state, i) + moved - tick.pose.position);
  const Vec3d c{apart.x + block.own.across * now.x, apart.y + block.own.across * now.y,
                apart.z + block.own.along * now.z - block.stick};
  // exact solution, then again across the shaft if the force along it is beyond its bounds
  Vec3d next = now - block.inverse * c;
  if (const double bounded = std::clamp(next.z, block.low, block.high); bounded != next.z) {
    const double along = bounded - now.z;
    const double rx = c.x + block.coupling.x * along, ry = c.y + block.coupling.y * along;
    next = {now.x - block.across[0] * rx - block.across[1] * ry,
            now.y - block.across[2] * rx - block.across[3] * ry, bounded};
  }
  const Vec3d change = frame * (next - now);
  force += change;
  return change;
}

}  // namespace

OwnCompliance unresolved_compliance(const NeedleTick& tick, const sfem::InnerPoint& at) {
  const auto e = std::size_t(at.element);
  return own_compliance(tick.needle, 1, log_of_resolved_radius(tick.inner, at), tick.inner.shear[e],
                        tick.inner.poisson[e]);
}

double spreading_force(const NeedleTick& tick) {
  if (tick.state.phase != NeedlePhase::kInside) return 0;
  return spreading_force(tick.needle, shaft_of(tick));
}

double spreading_energy(const NeedleTick& tick) {
  if (tick.state.phase != NeedlePhase::kInside) return 0;
  return spreading_energy(tick.needle, shaft_of(tick));
}

void extrapolate_forces(const NeedleTick& tick) {
  constexpr double kFarthest = 2;  // displacements of the last tick
  const NeedleState& state = tick.state;
  NeedleTrack& track = tick.track();
  const Vec3d step = tick.pose.position - state.pose.position;
  const double before2 = dot(state.step, state.step);
  // a rigid shaft that cuts has new points, whose forces do not go on as before
  const bool is_smooth = before2 > 0 && (tick.bends() || state.tip_force == 0);
  const double ratio = is_smooth ? std::clamp(dot(step, state.step) / before2, -kFarthest, kFarthest) : 0;
  for (std::size_t i = 0; i < track.points.size(); i++) {
    const Vec3d change = track.force[i] - std::exchange(track.before[i], track.force[i]);
    if (track.points[i].engaged > 1e-6 * tick.needle.spacing) track.force[i] += change * ratio;
  }
}

void find_positions(const NeedleTick& tick) {
  NeedleState& state = tick.state;
  NeedleTrack& track = tick.track();
  const std::size_t n = track.points.size();
  // load λ + s
  for (std::size_t i = 0; i < n; i++)
    for (std::size_t axis = 0; axis < 3; axis++) state.force_on[3 * i + axis] = track.force[i][int(axis)];
  add_spreading(tick, state.force_on);
  // x = b + C (λ + s)
  std::fill(state.x.begin(), state.x.end(), 0.0);
  for (std::size_t i = 0; i < n; i++) {
    const Vec3d b = tick.free_position(track.points[i]);
    for (std::size_t axis = 0; axis < 3; axis++) state.x[3 * i + axis] = b[int(axis)];
  }
  for (std::size_t i = 0; i < n; i++) {
    const Vec3d f{state.force_on[3 * i], state.force_on[3 * i + 1], state.force_on[3 * i + 2]};
    if (!(f == Vec3d{})) add_column(track, i, f, state.x.data());
  }
}

void solve_needle(const NeedleTick& tick, double tearing) {
  NeedleState& state = tick.state;
  NeedleTrack& track = tick.track();
  const std::size_t n = track.points.size();
  TURGOR_CHECK(n > 0 && n <= std::size_t(kMostNeedlePoints), "a track in use has an end");
  const Mat3d frame = push_axes(tick);
  NeedleBlock blocks[kMostNeedlePoints];
  for (std::size_t i = 0; i < n; i++) blocks[i] = block_of(tick, frame, i, tearing);
  // force that the needle can bear along itself
  double resistance = blocks[0].high;
  for (std::size_t i = 1; i < n; i++) resistance += blocks[i].high;
  // sweeps from the entry to the tip
  alignas(64) float moved[whole_lines(3 * kMostNeedlePoints)] = {};  // in this sweep [m]
  for (state.sweeps = 1; state.sweeps <= kMostSweeps; state.sweeps++) {
    double change = 0;
    for (std::size_t k = 1; k <= n; k++) {
      const std::size_t i = k < n ? k : 0;
      if (!blocks[i].is_solved) continue;
      const Vec3d step =
          solve_block(tick, frame, blocks[i], i, {moved[3 * i], moved[3 * i + 1], moved[3 * i + 2]});
      if (!(step == Vec3d{})) add_column(track, i, step, moved);
      for (std::size_t axis = 0; axis < 3; axis++) state.force_on[3 * i + axis] += step[int(axis)];
      change = std::max(change, norm(step));
    }
    for (std::size_t r = 0; r < 3 * n; r++) state.x[r] += double(std::exchange(moved[r], 0));
    if (change <= kNeedleTolerance * resistance) break;
  }
}

double along_compliance(const NeedleTick& tick, std::size_t i) {
  return i > 0 ? own_compliance(tick.track().points[i]).along : 0;
}
double across_compliance(const NeedleTick& tick, std::size_t i) {
  return i > 0 || tick.bends() ? own_compliance(tick.track().points[i]).across : 0;
}

double position_on_shaft(const NeedleTick& tick, std::size_t i) {
  if (tick.bends()) return position_on_bent_shaft(tick, i);
  const double own = i > 0 ? own_compliance(tick.track().points[i]).along : 0;
  return dot(position(tick.state, i) - tick.pose.position, tick.t()) +
         own * dot(tick.track().force[i], tick.t());
}

Vec3d arm_on_shaft(const NeedleTick& tick, std::size_t i) {
  const double along = position_on_shaft(tick, i);
  if (!tick.bends()) return tick.t() * along;
  return tick.t() * along +
         in_world(tick.pose.axes, deflection(tick.state.beam, beam_shape(tick.needle, -along)));
}

double follow_slip(const NeedleTick& tick) {
  NeedleTrack& track = tick.track();
  double work = 0;
  for (std::size_t i = 1; i < track.points.size(); i++) {
    NeedlePoint& point = track.points[i];
    if (!(point.engaged > 0)) continue;
    const double force = dot(track.force[i], tick.along(i)),
                 bound = tick.needle.friction * point.engaged / tick.stiffness;
    if (std::abs(force) < bound * (1 - 1e-9)) continue;
    const double at = position_on_shaft(tick, i);
    work += force * (point.stick - at), point.stick = at;
  }
  return work;
}

double engage(const NeedleTick& tick, double inserted) {
  NeedleTrack& track = tick.track();
  const double spacing = tick.needle.spacing;
  double released = tick.bends() ? hold_by_end(tick, inserted) : 0;
  for (std::size_t i = 1; i < track.points.size(); i++) {
    NeedlePoint& point = track.points[i];
    const double engaged = std::clamp(inserted - double(i - 1) * spacing, 0.0, spacing);
    if (engaged == point.engaged) continue;
    if (point.engaged == 0) {
      track.force[i] = {};
      point.stick = dot(position(tick.state, i) - tick.pose.position, tick.t());
    }
    // the displacement D λ is that of another length now
    const double before = own_energy(tick, i);
    const bool is_new = std::exchange(point.engaged, engaged) == 0;
    if (tick.bends() && is_new) released += misfit_work(tick, i, engaged);
    if (engaged > 0) released += before - own_energy(tick, i);
    if (engaged == 0) released += before, track.force[i] = {};
  }
  return -released;
}

double elastic_energy(const NeedleTick& tick) {
  const NeedleState& state = tick.state;
  const NeedleTrack& track = tick.track();
  double energy = 0;
  for (std::size_t i = 0; i < track.points.size(); i++) {
    const Vec3d u = position(state, i) - tick.free_position(track.points[i]);
    const Vec3d f{state.force_on[3 * i], state.force_on[3 * i + 1], state.force_on[3 * i + 2]};
    energy += 0.5 * dot(f, u) + own_energy(tick, i);
  }
  if (tick.bends()) energy += beam_energy(tick.needle, state.beam) / tick.stiffness;
  return energy;
}

}  // namespace turgor::contact
