// Forces of a needle whose shaft bends. Across the shaft, point i is held on the deflected axis:
//
//     (xᵢ + Dᵢ λᵢ − p − ηᵢ t − w(−ηᵢ)) across τᵢ = 0,     K w = −Hᵀ λ,     τᵢ = t − w'(−ηᵢ)
//
// H has the shape functions of the beam at the points and K its stiffness, so that the compliance of the
// points is C + D + H K⁻¹ Hᵀ. Friction acts along τᵢ as on a rigid shaft. The end of the crack holds the
// shaft between the last point and the tip that cuts. Conjugate gradients find the forces across the shaft,
// Gauss–Seidel in a box those along it, in turns. The preconditioner is the beam on independent springs, one
// a point [Winkler 1867]; it is solved by bands.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "turgor/contact/needle_tick.hpp"
#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

constexpr int kMostTurns = 20, kMostGradients = 60;
constexpr double kBentTolerance = 3e-5;  // change of a force in a turn, relative to the needle's resistance
constexpr double kShareOfTurn = 0.5;     // of a turn's first change, at which its conjugate gradients end

/// A point on the bent shaft in this tick.
struct BentPoint {
  BeamShape shape;
  Vec3d along;                           // τ
  Vec3d straight;                        // position on the shaft without deflection [m]
  double inverse = 1;                    // 1/|τ|²
  double own_along = 0, own_across = 0;  // D [m/N]
  double compliance = 0;                 // of C + D along τ [m/N]
  double spring = 0;                     // of the preconditioner [N/m]
  double low = 0, high = 0;              // bounds of the force along τ [N]
  double beside = 0;                     // part of the crack's offset along τ [m]
  bool holds_along = false, holds_across = false;

  Vec3d across(Vec3d v) const { return v - along * (dot(v, along) * inverse); }
};

/// Unknowns of a tick. Vectors have one entry a point.
struct BentShaft {
  const NeedleTick& tick;
  std::size_t count;
  BeamMatrix stiffness{}, on_springs{};  // factors: of K, and of K with the springs
  BentPoint point[kMostNeedlePoints];
  Vec3d r[kMostNeedlePoints], z[kMostNeedlePoints], p[kMostNeedlePoints];  // of conjugate gradients
  alignas(64) float moved[whole_lines(3 * kMostNeedlePoints)];             // C times forces [m]

  explicit BentShaft(const NeedleTick& t) : tick(t), count(t.track().points.size()) {}
  Vec3d in_tool(Vec3d v) const {
    return {dot(v, tick.pose.axes.column[0]), dot(v, tick.pose.axes.column[1]), 0};
  }
  Vec3d deflected(const NeedleBeam& beam, std::size_t i) const {
    return in_world(tick.pose.axes, deflection(beam, point[i].shape));
  }
};

/// moved = C forces; forces of zero are skipped.
void multiply_by_compliance(BentShaft& shaft, const Vec3d* forces) {
  std::fill_n(shaft.moved, whole_lines(3 * shaft.count), 0.0F);
  for (std::size_t i = 0; i < shaft.count; i++)
    if (!(forces[i] == Vec3d{})) add_column(shaft.tick.track(), i, forces[i], shaft.moved);
}
Vec3d moved(const BentShaft& shaft, std::size_t i) {
  return {shaft.moved[3 * i], shaft.moved[3 * i + 1], shaft.moved[3 * i + 2]};
}

/// Changes the force on one point, and with it `moved`.
void change_force(BentShaft& shaft, std::size_t i, Vec3d change) {
  NeedleState& state = shaft.tick.state;
  NeedleTrack& track = shaft.tick.track();
  track.force[i] += change;
  for (std::size_t axis = 0; axis < 3; axis++) state.force_on[3 * i + axis] += change[int(axis)];
  add_column(track, i, change, shaft.moved);
}

BentPoint bent_point(const NeedleTick& tick, std::size_t i, double tearing) {
  NeedlePoint& point = tick.track().points[i];
  const bool is_end = i == 0, touches = tick.state.phase == NeedlePhase::kTouching;
  const double stick = is_end ? 0 : point.stick;
  BentPoint bent{.shape = beam_shape(tick.needle, -stick),
                 .along = tick.t(),
                 .straight = tick.pose.position + tick.t() * stick};
  // direction of the shaft; the force of the tip has its given part along t
  if (!touches) bent.along -= in_world(tick.pose.axes, deflection_slope(tick.state.beam, bent.shape));
  if (!is_end) bent.along = normalized(bent.along);
  bent.inverse = 1 / dot(bent.along, bent.along);
  if (is_end && !touches) bent.beside = dot(bent.along, tick.track().offset);
  point.along = bent.along;
  // what it holds
  bent.holds_along = is_end ? tearing > 0 : point.engaged > 1e-6 * tick.needle.spacing;
  bent.holds_across = is_end ? touches || point.engaged > 1e-6 * tick.needle.spacing : bent.holds_along;
  if (!bent.holds_along && !bent.holds_across) return bent;
  bent.own_along = along_compliance(tick, i), bent.own_across = across_compliance(tick, i);
  const double bound = (is_end ? tearing : tick.needle.friction * point.engaged) / tick.stiffness;
  bent.low = is_end ? 0 : -bound, bent.high = bound;
  // compliances
  const Mat3d block = own_block(tick.track(), i);
  bent.compliance = dot(bent.along, block * bent.along) + bent.own_along;
  bent.spring = bent.holds_across
                    ? 1 / (bent.own_across + (block.column[0].x + block.column[1].y + block.column[2].z) / 3)
                    : 0;
  return bent;
}

/// Factors of K, and of K + Hᵀ S H with the springs S, at a stiffness of 1.
void factorize_beam(BentShaft& shaft) {
  BeamMatrix matrix = beam_stiffness(shaft.tick.needle);
  for (auto& row : matrix.band)
    for (double& entry : row) entry /= shaft.tick.stiffness;
  shaft.stiffness = shaft.on_springs = matrix;
  for (std::size_t i = 0; i < shaft.count; i++) {
    const BentPoint& point = shaft.point[i];
    for (std::size_t a = 0; a < 4 && point.holds_across; a++)
      for (std::size_t b = 0; b <= a; b++)
        if (const std::size_t row = std::size_t(point.shape.first) + a; row < kBeamUnknowns)
          shaft.on_springs.band[row][a - b] += point.spring * point.shape.value[a] * point.shape.value[b];
  }
  factorize(shaft.stiffness), factorize(shaft.on_springs);
}

/// Deflection of the beam by forces on the tissue, with one of the factors.
NeedleBeam bend_by(const BentShaft& shaft, const BeamMatrix& factor, const Vec3d* forces) {
  NeedleBeam beam;
  for (std::size_t i = 0; i < shaft.count; i++)
    if (!(forces[i] == Vec3d{})) add_load(shaft.point[i].shape, shaft.in_tool(forces[i] * -1.0), beam);
  solve(factor, beam);
  return beam;
}

/// x + D λ − P, without D along the shaft.
Vec3d apart_from_shaft(const BentShaft& shaft, std::size_t i) {
  const BentPoint& point = shaft.point[i];
  const NeedleTick& tick = shaft.tick;
  return position(tick.state, i) + point.across(tick.track().force[i]) * point.own_across - point.straight -
         shaft.deflected(tick.state.beam, i);
}

/// Gauss–Seidel for the forces along the shaft, from the entry to the tip. Returns the largest change [N].
double sweep_along(BentShaft& shaft) {
  NeedleState& state = shaft.tick.state;
  double largest = 0;
  std::fill_n(shaft.moved, whole_lines(3 * shaft.count), 0.0F);
  for (std::size_t k = 1; k <= shaft.count; k++) {
    const std::size_t i = k < shaft.count ? k : 0;
    const BentPoint& point = shaft.point[i];
    if (!point.holds_along) continue;
    const Vec3d force = shaft.tick.track().force[i];
    const double now = dot(force, point.along) * point.inverse;
    const double apart =
        dot(apart_from_shaft(shaft, i) + moved(shaft, i), point.along) - point.beside + point.own_along * now;
    const double next = std::clamp(now - apart / point.compliance, point.low, point.high);
    // a tip that is not held across has no force there
    Vec3d change = point.along * (next - now);
    if (!point.holds_across) change = point.along * next - force;
    if (!(change == Vec3d{})) change_force(shaft, i, change);
    largest = std::max(largest, norm(change));
  }
  for (std::size_t r = 0; r < 3 * shaft.count; r++) state.x[r] += double(shaft.moved[r]);
  return largest;
}

/// z = M⁻¹ r: springs S and the beam, M⁻¹ = S − S H (K + Hᵀ S H)⁻¹ Hᵀ S. Returns the largest entry of z [N].
double precondition(const BentShaft& shaft, const Vec3d* r, Vec3d* z) {
  for (std::size_t i = 0; i < shaft.count; i++) z[i] = r[i] * shaft.point[i].spring;
  const NeedleBeam beam = bend_by(shaft, shaft.on_springs, z);
  double largest = 0;
  for (std::size_t i = 0; i < shaft.count; i++) {
    const BentPoint& point = shaft.point[i];
    if (!point.holds_across) continue;
    z[i] = point.across(z[i] + shaft.deflected(beam, i) * point.spring);
    largest = std::max(largest, dot(z[i], z[i]));
  }
  return std::sqrt(largest);
}

/// Conjugate gradients for the forces across the shaft, until they change by less than the tolerance, or by
/// less than a share of their first change: the forces along the shaft move them again in the next turn.
/// Returns the first change, the largest of a point [N].
double solve_across(BentShaft& shaft, double tolerance) {
  NeedleState& state = shaft.tick.state;
  std::vector<Vec3d>& force = shaft.tick.track().force;
  const std::size_t n = shaft.count;
  Vec3d *r = shaft.r, *z = shaft.z, *p = shaft.p;
  const auto inner = [&](const Vec3d* a, const Vec3d* b) {
    double sum = 0;
    for (std::size_t i = 0; i < n; i++) sum += dot(a[i], b[i]);
    return sum;
  };
  // residual
  state.beam = bend_by(shaft, shaft.stiffness, force.data());
  for (std::size_t i = 0; i < n; i++)
    r[i] = shaft.point[i].holds_across ? shaft.point[i].across(apart_from_shaft(shaft, i)) * -1.0 : Vec3d{};
  const double first = precondition(shaft, r, z), goal = std::max(tolerance, kShareOfTurn * first);
  double largest = first, rz = inner(r, z);
  std::copy_n(z, n, p);
  for (int step = 0; step < kMostGradients && largest > goal && rz > 0; step++) {
    // A p with A = C + D + H K⁻¹ Hᵀ
    multiply_by_compliance(shaft, p);
    const NeedleBeam beam = bend_by(shaft, shaft.stiffness, p);
    double curvature = 0;
    for (std::size_t i = 0; i < n; i++) {
      const BentPoint& point = shaft.point[i];
      if (!point.holds_across) continue;
      z[i] = point.across(moved(shaft, i) + p[i] * point.own_across - shaft.deflected(beam, i));
      curvature += dot(z[i], p[i]);
    }
    if (!(curvature > 0)) break;
    // step
    const double length = rz / curvature;
    add_scaled(state.beam, beam, length);
    for (std::size_t i = 0; i < n; i++) {
      force[i] += p[i] * length, r[i] -= z[i] * length;
      for (std::size_t axis = 0; axis < 3; axis++) {
        state.force_on[3 * i + axis] += length * p[i][int(axis)];
        state.x[3 * i + axis] += length * double(shaft.moved[3 * i + axis]);
      }
    }
    state.sweeps++;
    // next direction
    largest = precondition(shaft, r, z);
    const double before = rz;
    rz = inner(r, z);
    for (std::size_t i = 0; i < n; i++) p[i] = z[i] + p[i] * (rz / before);
  }
  return first;
}

}  // namespace

void solve_bending_needle(const NeedleTick& tick, double tearing) {
  NeedleState& state = tick.state;
  BentShaft shaft(tick);
  TURGOR_CHECK(shaft.count > 0 && shaft.count <= std::size_t(kMostNeedlePoints), "a track in use has an end");
  for (std::size_t i = 0; i < shaft.count; i++) shaft.point[i] = bent_point(tick, i, tearing);
  factorize_beam(shaft);
  // forces that the needle can bear along itself, and those it bears now
  double scale = 0;
  for (std::size_t i = 0; i < shaft.count; i++)
    scale += std::max(shaft.point[i].high, norm(tick.track().force[i]));
  // across and along in turns
  state.sweeps = 0;
  for (int turn = 0; turn < kMostTurns; turn++) {
    const double across = solve_across(shaft, kBentTolerance * scale);
    state.sweeps++;
    if (const double along = sweep_along(shaft); std::max(across, along) <= kBentTolerance * scale) break;
  }
  state.beam = bend_by(shaft, shaft.stiffness, tick.track().force.data());
}

double position_on_bent_shaft(const NeedleTick& tick, std::size_t i) {
  const NeedlePoint& point = tick.track().points[i];
  const double stick = i > 0 ? point.stick : 0;
  const Vec3d on_shaft =
      tick.pose.position + tick.t() * stick +
      in_world(tick.pose.axes, deflection(tick.state.beam, beam_shape(tick.needle, -stick)));
  return stick + dot(position(tick.state, i) - on_shaft, point.along) +
         along_compliance(tick, i) * dot(tick.track().force[i], point.along);
}

// A spring of stiffness k = ℓ/D a length that is u long stores ½ k u² a length.
double misfit_work(const NeedleTick& tick, std::size_t i, double engaged) {
  const NeedlePoint& point = tick.track().points[i];
  const double across = across_compliance(tick, i), stick = i > 0 ? point.stick : 0;
  if (!(across > 0)) return 0;
  const BeamShape shape = beam_shape(tick.needle, -stick);
  Vec3d misfit = position(tick.state, i) - tick.pose.position -
                 in_world(tick.pose.axes, deflection(tick.state.beam, shape));
  misfit -= tick.t() * dot(misfit, tick.t());
  return 0.5 * engaged / (point.engaged * across) * dot(misfit, misfit);
}

double hold_by_end(const NeedleTick& tick, double inserted) {
  NeedleTrack& track = tick.track();
  NeedlePoint& end = track.points[0];
  const bool cuts = !track.is_through && tick.state.tip_force > 0;
  const double covered = double(track.points.size() - 1) * tick.needle.spacing;
  const double length = cuts ? std::clamp(inserted - covered, 0.0, tick.needle.spacing) : 0;
  const double before = end.engaged, grown = length - before;
  if (grown > 0) {
    end.engaged = length;
    return misfit_work(tick, 0, grown);
  }
  // a new point takes over from the end
  const Vec3d f = track.force[0];
  const Vec3d across = f - end.along * (dot(f, end.along) / dot(end.along, end.along));
  const double stored = 0.5 * across_compliance(tick, 0) * dot(across, across);
  end.engaged = length;
  return before > 0 ? grown / before * stored : 0;
}

Vec3d cut_position(const NeedleTick& tick, double ahead) {
  Vec3d& offset = tick.track().offset;
  const double side = bevel_offset(tick.needle), around = tick.needle.bevel_toward * std::numbers::pi / 180;
  if (!(side > 0)) return tick.tip();
  // the edge cuts sideways only while it advances: from one side to the other within two lengths of the face
  const Vec3d edge = in_world(tick.pose.axes, Vec3d{std::cos(around), std::sin(around), 0}) * side;
  const double most = side * ahead / bevel_length(tick.needle), away = norm(edge - offset);
  offset = away > most ? offset + (edge - offset) * (most / away) : edge;
  return tick.tip() + offset;
}

}  // namespace turgor::contact
