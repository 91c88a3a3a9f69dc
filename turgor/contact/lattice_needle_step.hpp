// Stages of a needle's step in a lattice and their common data; lattice_needle.cpp calls them.
#pragma once

#include "turgor/contact/lattice_needle.hpp"

namespace turgor::contact {

/// Tip and axis of a needle in the lattice frame.
struct NeedleAxis {
  Vec3d tip, t;  // [m]; direction of a push, unit
};
NeedleAxis axis_in_lattice(const lattice::Model& model, const Pose& pose);
inline LatticeNeedleTrack& track_of(LatticeNeedle& state) { return state.tracks[std::size_t(state.track)]; }
inline const LatticeNeedleTrack& track_of(const LatticeNeedle& state) {
  return state.tracks[std::size_t(state.track)];
}

// lattice_needle_track.cpp

/// Present position of a material point, lattice frame [m].
Vec3d position_of(const lattice::Motion& motion, const lattice::EmbeddedPoint& at, Vec3d rest);
/// Looks for the surface between two tips, patient frame: an old track, or a new one of length 0.
void find_entry(const NeedleSurroundings& around, const Needle& needle, Vec3d from, Vec3d to,
                LatticeNeedle& state);
/// Moves the end of the crack to the tip, which is `ahead` of it along t, and adds points behind it. Returns
/// the share of `ahead` that it cuts: it stops at the far surface and where the tissue is tougher.
double cut_to_tip(const NeedleSurroundings& around, const Needle& needle, double ahead, LatticeNeedle& state);
/// Embeds all points again after a cut; tracks whose tissue was removed end.
void embed_tracks(const NeedleSurroundings& around, LatticeNeedle& state);

// lattice_needle_springs.cpp

/// Compliance D of a point at its length ℓ.
OwnCompliance own_compliance(const lattice::Model& model, const Needle& needle,
                             const LatticeNeedlePoint& point);
/// Largest force of friction on a point [N].
double friction_bound(const Needle& needle, const LatticeNeedlePoint& point);
/// Force F at which the crack grows, and that of the tissue below a surface that is not punctured yet [N].
double tearing_force(const Needle& needle, const LatticeNeedle& state);
double tearing_inside(const Needle& needle, const LatticeNeedle& state);
/// Position of a point on the shaft along t, relative to the tip [m].
double position_on_shaft(const lattice::Model& model, const Needle& needle, const NeedleAxis& axis,
                         const LatticeNeedlePoint& point);
InsertedShaft shaft_of(const LatticeNeedle& state);
/// Shares of the load of the spread crack, and the points with springs.
void choose_springs(const lattice::Model& model, const Needle& needle, LatticeNeedle& state);

}  // namespace turgor::contact
