// A needle in an sfem body, with its force at every tick. Its track is a row of material points Xᵢ, each for
// a length ℓᵢ of the shaft; the first is the end of the crack. C is the compliance between them
// (models/sfem/inner_green.hpp), b their positions without the needle, t the direction in which the needle is
// pushed, p its tip, λᵢ the force on point i:
//
//     x = b + C (λ + s)                                  s: load of the spread crack at the tip
//     (xᵢ + Dᵢ λᵢ − p) across t = 0                       the shaft is straight (bilateral)
//     (xᵢ + Dᵢ λᵢ − p)·t = ηᵢ  while |λᵢ·t| < f ℓᵢ         the point sticks
//     |λᵢ·t| = f ℓᵢ            otherwise                  it slips, and ηᵢ follows
//     0 ≤ F = λ₀·t ≤ J w,  (x₀ − p)·t ≥ 0                 the tip
//     F dl = J w dl                                       the crack grows at F = J w
//
// These conditions describe the minimum of a convex function of λ in a box. Block Gauss–Seidel with the exact
// solution of each point finds it. The mesh cannot resolve the needle. Between the radius a of the needle and
// the radius r₀ of a line force that the mesh resolves, the displacement is that of a well in a reservoir:
//
//     Dᵢ = ln(r₀/a)/(2π G ℓᵢ)                              along
//     Dᵢ = (3 − 4ν) ln(r₀/a)/(8π G (1 − ν) ℓᵢ)             across
//
// [Mahvash, Dupont 2010; Barnett 2015; Peaceman 1978]
//
// Before it enters, the tip is the end of a track of length 0 that tears at the surface's own toughness. The
// far surface has one, too. A crack stops where tissue is tougher. In an old track nothing tears. Work of the
// hand = cutting + friction + spreading + elastic energy.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "turgor/contact/free_motion.hpp"
#include "turgor/contact/needle_beam.hpp"
#include "turgor/contact/needle_mechanics.hpp"
#include "turgor/contact/needle_reading.hpp"
#include "turgor/contact/tool_io.hpp"
#include "turgor/core/aligned.hpp"
#include "turgor/models/sfem/inner_green.hpp"

namespace turgor::contact {

/// Material point of a track.
struct NeedlePoint {
  sfem::InnerPoint at;
  Vec3d rest;          // position at rest [m]
  double arc = 0;      // distance from the entry along the track [m]
  double engaged = 0;  // ℓ: length of the shaft that it stands for; 0 = the tip has not reached it [m]
  double stick = 0;    // η: position along t, relative to the tip, to which it sticks [m]
  Vec3d along;         // direction of a bent shaft there in the last tick; zero = t
  OwnCompliance unresolved;  // D ℓ [m²/N]
};

/// Count of floats, rounded up to whole cache lines, so that loops over them are in lanes to the end.
constexpr std::size_t whole_lines(std::size_t count) { return (count + 15) / 16 * 16; }

/// Crack that a needle has cut. Arrays have room for the largest number of points.
struct NeedleTrack {
  std::vector<NeedlePoint> points;   // the end of the crack, then points from the entry on; empty = unused
  std::vector<Vec3d> force;          // λ of each [N]
  std::vector<Vec3d> before;         // the same one tick earlier [N]
  aligned_vector<float> compliance;  // C, column-major with compliance_stride numbers a column [m/N]
  double length = 0;                 // of the crack [m]
  Vec3d entry;                       // at rest [m]
  bool is_at_exit = false;           // its end is the far surface, which is not torn yet
  bool is_through = false;           // it left the body: the tip meets nothing
  long order = 0;                    // counts tracks
  Vec3d offset;                      // of the end from the tip that cut it, by a bevel [m]
};

/// State of one needle, owned by the thread that ticks.
struct NeedleState {
  NeedlePhase phase = NeedlePhase::kOutside;
  bool seen = false;       // it has a pose
  Pose pose;               // of the last tick
  Vec3d step;              // displacement of the hand in the last tick [m]
  int track = 0;           // in use while it touches or is inside
  double inserted = 0;     // [m]
  Vec3d force, torque;     // on the needle after the last tick, the torque about its tip [N] [N·m]
  double tip_force = 0;    // F after the last tick [N]
  double entry_force = 0;  // largest F before the first puncture [N]
  int punctures = 0;
  long tracks_made = 0;
  int sweeps = 0;       // of the last tick
  bool beyond = false;  // the tip is beyond the elements whose Green's functions are known
  NeedleWork work;
  NeedleReading reading;
  NeedleBeam beam;  // deflection of a shaft that bends
  std::vector<NeedleTrack> tracks;
  FreeMotionInterpolation motion;  // of InnerGreen's vertices, without this needle
  std::vector<Vec3d> free;         // its present value [m]
  std::vector<Vec3d> carried;      // the same at the points of the track in use, after the last tick [m]
  std::size_t carried_points = 0;  // number of them
  // workspace of a tick
  aligned_vector<double> x;            // positions, three numbers a point; whole_lines of them [m]
  std::vector<double> force_on;        // λ + s of each point, three numbers each [N]
  std::vector<Vec3d> carried_by;       // change of `carried` in this tick [m]
  std::vector<double> row;             // C between one point and all vertices of InnerGreen
  std::vector<Vec3d> force_on_vertex;  // of InnerGreen [N]
};

/// Needles of one body: state, and the Green's functions around them.
struct NeedleTouch {
  std::shared_ptr<const sfem::InnerGreen> inner;  // null without needles
  std::vector<NeedleState> needles;               // one for each tool; unused for other tools
};

/// State of a needle outside of the body, with memory for all of its tracks.
NeedleState make_needle_state(const sfem::InnerGreen& inner, const Needle& needle);

/// Lists the elements of the mesh that all tracks pass: at most kMostTracks · kMostNeedlePoints a needle.
void list_track_elements(const NeedleTouch& touch, std::vector<int>& elements);

/// One tick of a needle. `free`: displacement of the vertices of `inner` without this needle;
/// empty = none [m]. Forces scale with `stiffness`, the present stiffness divided by that
/// of `inner`. Does not allocate or wait.
ToolReading tick_needle(const sfem::InnerGreen& inner, const Needle& needle, std::span<const Vec3d> free,
                        const Pose& pose, double stiffness, NeedleState& state);

/// Adds the forces of a needle on the body to the vertices of `inner`, at a stiffness of 1 [N].
void add_needle_forces(const sfem::InnerGreen& inner, const NeedleState& state, std::span<Vec3d> of_vertices);

}  // namespace turgor::contact
