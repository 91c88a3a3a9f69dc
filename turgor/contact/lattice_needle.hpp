// A needle in a lattice body. Its forces are those of needle_touch.hpp, solved together with the body once a
// step: each point of its track is embedded in a cell and has a spring in the systems of the cell's nodes
// (models/lattice/mechanics/point_springs.hpp). p is the tip at the end of the step, t the direction of a
// push, x the position of a point, D the displacement that the cells do not resolve:
//
//     λ across t = −D⁻¹ (x − p) across t                      the shaft is straight
//     λ·t = D⁻¹ (η − (x − p)·t) in [−f ℓ, f ℓ]                 sticks; else it slips, and η follows
//     F = λ₀·t in [0, J w],  (x₀ − p)·t ≥ 0                    the tip
//
// A spring of stiffness 1/D is about as stiff as its cells, so that sweeps converge as without the needle.
// The tip has a penalty within a step and a multiplier from step to step (augmented Lagrangian, Hestenes
// 1969). At F = J w the crack grows to the tip. Work of the hand = cutting + friction + spreading + elastic
// energy, where the elastic energy is that of D and the work that the body took; inertia and damping are part
// of it.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "turgor/contact/local_contact.hpp"
#include "turgor/contact/needle_mechanics.hpp"
#include "turgor/contact/needle_reading.hpp"
#include "turgor/models/lattice/mechanics/point_springs.hpp"
#include "turgor/models/lattice/model/inputs.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::contact {

/// Resistance of the tissue at a position. Negative values are the needle's own; bone has an infinite
/// toughness.
struct NeedleTissue {
  int material = 0;       // for NeedleReading
  double toughness = -1;  // [J/m²]
  double friction = -1;   // along the shaft, per length [N/m]
};

/// Material point of a track. Positions and forces are in the lattice frame.
struct LatticeNeedlePoint {
  lattice::EmbeddedPoint at;
  Vec3d rest;          // [m]
  double arc = 0;      // distance from the entry along the track [m]
  double engaged = 0;  // ℓ: length of the shaft that it stands for [m]
  double stick = 0;    // η: position along t, relative to the tip, to which it sticks [m]
  NeedleTissue tissue;
  Vec3d force;              // λ [N]
  Vec3d multiplier;         // part of the tip's λ that is kept from step to step [N]
  Vec3d spread;             // share of the load of the spread crack in this step [N]
  Vec3d load;               // λ and that share in the last step [N]
  Vec3d x;                  // after the last step [m]
  bool is_sprung = false;   // has a spring in this step
  bool is_coupled = false;  // and that spring couples it to the needle
};

/// Crack that a needle has cut.
struct LatticeNeedleTrack {
  std::vector<LatticeNeedlePoint> points;  // the end of the crack, then points from the entry on
  double length = 0;                       // [m]
  lattice::EmbeddedPoint entry_at;
  Vec3d entry;              // at rest, lattice frame [m]
  bool is_at_exit = false;  // its end is the far surface, which is not torn yet
  double gap = 0;           // of the tip beyond an end that stopped the crack, after the last step [m]
  bool is_through = false;  // it left the body: the tip meets nothing
  long order = 0;           // counts tracks
};

/// State of one needle.
struct LatticeNeedle {
  NeedlePhase phase = NeedlePhase::kOutside;
  bool seen = false;       // it has a pose
  Pose before, pose;       // at the start and the end of the last step, patient frame
  int track = 0;           // in use while it touches or is inside
  double inserted = 0;     // [m]
  Vec3d force, torque;     // on the needle, about its tip, patient frame [N] [N·m]
  double tip_force = 0;    // F [N]
  double entry_force = 0;  // largest F before the first puncture [N]
  int punctures = 0;
  long tracks_made = 0;
  double given = 0;  // work that the body took, so far [J]
  NeedleWork work;
  NeedleReading reading;
  std::vector<LatticeNeedleTrack> tracks;
  std::size_t cuts = 0;  // cut version of the embedded points
  bool settled = false;  // nothing changed in the last step
};

/// Tissue with the needle's own values everywhere.
inline NeedleTissue of_needle(Vec3d) { return {}; }

/// Body around a needle during a step.
struct NeedleSurroundings {
  const lattice::Model& model;
  const lattice::State& state;
  const lattice::BodySurface& surface;
  const lattice::Fragments& fragments;
  std::function<NeedleTissue(Vec3d rest)> tissue_at;  // at a rest position, lattice frame [m]
};

/// Needle outside of the body.
LatticeNeedle make_lattice_needle();
/// Takes a needle out of the body without a path, as after a teleport. Its tracks stay.
void release_needle(LatticeNeedle& state);

/// Before a step that moves the needle to a pose [patient frame]: finds the surface on its path, and the
/// points with springs.
void begin_needle_step(const NeedleSurroundings& around, const Needle& needle, const Pose& to,
                       LatticeNeedle& state);
/// Appends the springs of a needle.
void append_needle_springs(const LatticeNeedle& state, std::vector<lattice::PointSpring>& springs);
/// Updates the forces λ from the present positions, and the springs. Returns the number of springs.
std::size_t update_needle_springs(const lattice::Model& model, const lattice::Motion& motion,
                                  const Needle& needle, LatticeNeedle& state,
                                  std::span<lattice::PointSpring> springs);
/// After the step: puncture, slip, growth of the crack, forces on the needle, and work.
void finish_needle_step(const NeedleSurroundings& around, const Needle& needle, LatticeNeedle& state);

/// Complete lattice step with one needle. `inputs` must not contain springs.
lattice::StepReport step_with_needle(const Exec& exec, const lattice::Model& model, lattice::State& state,
                                     const lattice::BodySurface& surface, const Needle& needle,
                                     const Pose& to, lattice::Inputs inputs, double dt, LatticeNeedle& of,
                                     const std::function<NeedleTissue(Vec3d rest)>& tissue_at = of_needle);

/// Depth of the tip below the entry at rest, along the needle; 0 outside [m].
double needle_depth(const lattice::Model& model, const LatticeNeedle& state);
/// Points that bear force.
int bearing_points(const LatticeNeedle& state);
/// Contact for haptic ticks: a force along the needle between its bounds, and springs across it.
LocalContact local_contact(const lattice::Model& model, const Needle& needle, const LatticeNeedle& state);

}  // namespace turgor::contact
