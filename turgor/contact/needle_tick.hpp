// Stages of a needle's tick and their common data; needle_touch.cpp calls them.
#pragma once

#include "turgor/contact/needle_touch.hpp"

namespace turgor::contact {

/// One tick of one needle. Forces are those at a stiffness of 1.
struct NeedleTick {
  const sfem::InnerGreen& inner;
  const Needle& needle;
  std::span<const Vec3d> free;
  Pose pose;
  double stiffness = 1;
  NeedleState& state;

  Vec3d t() const { return -1.0 * pose.axes.column[2]; }  // direction of a push
  bool bends() const { return needle.bending > 0; }
  /// Position of the tip, which bending moves across the shaft.
  Vec3d tip() const {
    return bends() ? pose.position + in_world(pose.axes, at_tip(state.beam)) : pose.position;
  }
  /// Direction of the shaft at a point.
  Vec3d along(std::size_t point) const { return bends() ? track().points[point].along : t(); }
  NeedleTrack& track() const { return state.tracks[std::size_t(state.track)]; }
  Vec3d free_position(const NeedlePoint& point) const {
    return free.empty() ? point.rest : point.rest + sfem::at_point(inner, point.at, free);
  }
};

// needle_track.cpp

/// Numbers between columns of C.
inline std::size_t compliance_stride(const NeedleTrack& track) { return whole_lines(3 * track.force.size()); }
/// x += C f for a force on one point, three numbers a point. Floats are for changes within a tick, doubles
/// for positions. x has room for whole_lines of its rows; those beyond the points are unused.
template <class Number>
void add_column(const NeedleTrack& track, std::size_t i, Vec3d f, Number* x) {
  const std::size_t stride = compliance_stride(track), rows = whole_lines(3 * track.points.size());
  const float *a = &track.compliance[3 * i * stride], *b = a + stride, *c = b + stride;
  const auto fx = Number(f.x), fy = Number(f.y), fz = Number(f.z);
  TURGOR_LANES
  for (std::size_t r = 0; r < rows; r++) x[r] += Number(a[r]) * fx + Number(b[r]) * fy + Number(c[r]) * fz;
}
/// Block of C of a point with itself.
inline Mat3d own_block(const NeedleTrack& track, std::size_t i) {
  const std::size_t stride = compliance_stride(track);
  const float* c = &track.compliance[3 * i * stride + 3 * i];
  return {{{c[0], c[1], c[2]},
           {c[stride], c[stride + 1], c[stride + 2]},
           {c[2 * stride], c[2 * stride + 1], c[2 * stride + 2]}}};
}
Vec3d position(const NeedleState& state, std::size_t point);
/// A track of length 0 whose end is this point; replaces the oldest one if all are in use. Returns its index.
int begin_track(const NeedleTick& tick, const sfem::InnerPoint& at, Vec3d rest);
/// Moves the end of the crack to the tip, which is `ahead` of it along t, and adds points behind it. Returns
/// the share of `ahead` that it cuts: it stops at the far surface and where the tissue is tougher.
double cut_to_tip(const NeedleTick& tick, double ahead);
/// Toughness at a point: of its element, or the needle's own [J/m²].
double toughness_at(const NeedleTick& tick, const sfem::InnerPoint& at);
/// Length of the track behind the tip, from the present positions; negative: the tip is in front of the entry
/// [m].
double inserted_length(const NeedleTick& tick);
/// First surface point that the tip has passed between two positions.
struct SurfaceHit {
  sfem::InnerPoint at;
  Vec3d rest, now;      // positions at rest and now [m]
  double fraction = 2;  // of the distance; above 1 = none
};
SurfaceHit first_surface_hit(const NeedleTick& tick, Vec3d from, Vec3d to);
/// Track whose entry is within a needle's radius of a position; -1 = none.
int track_entered_at(const NeedleTick& tick, Vec3d position);

// needle_solve.cpp

/// Force of the spread crack on the tip, and the energy stored in it [N] [J].
double spreading_force(const NeedleTick& tick);
double spreading_energy(const NeedleTick& tick);
/// Continues the change of the forces in the last tick, in proportion to the displacement of the hand. The
/// forces are unique; a start near them takes fewer sweeps.
void extrapolate_forces(const NeedleTick& tick);
/// Positions x = b + C (λ + s) and their load, from these forces.
void find_positions(const NeedleTick& tick);
/// D of a point for a length of 1 m [m²/N].
OwnCompliance unresolved_compliance(const NeedleTick& tick, const sfem::InnerPoint& at);
/// D of a point along and across the shaft [m/N].
double along_compliance(const NeedleTick& tick, std::size_t point);
double across_compliance(const NeedleTick& tick, std::size_t point);
/// Solves for λ of all points on a rigid shaft, and for the tip with at most `tearing` [N].
void solve_needle(const NeedleTick& tick, double tearing);
/// Lets slipping points follow the shaft, and returns the work of friction [J].
double follow_slip(const NeedleTick& tick);
/// Sets ℓ of every point for this inserted length; points that the tip reaches stick where they are. Returns
/// the energy of D that changes with ℓ, which friction gains or bears [J].
double engage(const NeedleTick& tick, double inserted);
/// Position of a point on the shaft along t, relative to the tip [m].
double position_on_shaft(const NeedleTick& tick, std::size_t point);
/// The same from the tip at rest of the beam to the shaft at the point, in all directions [m].
Vec3d arm_on_shaft(const NeedleTick& tick, std::size_t point);
/// Elastic energy: of C, and of the displacements D that the mesh does not resolve [J].
double elastic_energy(const NeedleTick& tick);

// needle_bend.cpp

/// solve_needle for a shaft that bends; also its deflection.
void solve_bending_needle(const NeedleTick& tick, double tearing);
/// Position on the bent shaft to which a point belongs, along t from the tip [m].
double position_on_bent_shaft(const NeedleTick& tick, std::size_t point);
/// Energy that `engaged` meters of the shaft store because tissue that was cut beside it holds it now [J].
double misfit_work(const NeedleTick& tick, std::size_t point, double engaged);
/// Lets the end of the crack hold the shaft between the last point and the tip that cuts. Returns the energy
/// that it stores [J].
double hold_by_end(const NeedleTick& tick, double inserted);
/// Position to which the tip cuts when it advances: beside the tip, if it has a bevel [m].
Vec3d cut_position(const NeedleTick& tick, double ahead);

}  // namespace turgor::contact
