// Stitches that close a wound. A stitch is a closed loop of thread through points of the tissue, along which
// it slides without friction. Its energy is that of a unilateral spring of the whole loop. Opposite points of
// the wound's walls do not pass each other. Both are coupled by multipliers that follow from sweep to sweep
// (augmented Lagrangian), so that a stiff thread does not slow the sweeps down.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/mechanics/point_springs.hpp"

namespace turgor::lattice {

/// Thread of a suture.
struct Thread {
  double stiffness = 0;  // force per strain, E A [N]
  double strength = 0;   // tension at which it breaks [N]
};

enum class StitchPhase : std::uint8_t { kWaiting, kPulled, kKnotted, kPulledOut, kBroken };
inline bool bears(StitchPhase phase) {
  return phase == StitchPhase::kPulled || phase == StitchPhase::kKnotted;
}

/// A point on each side of a blade. Without `parted`, the blade did not separate the tissue.
struct EmbeddedPair {
  EmbeddedPoint left, right;
  bool parted = false;
};

/// Loop of thread through points on both sides of a wound.
struct Stitch {
  std::vector<Vec3d> rest;  // points in the order of the thread, lattice frame [m]
  std::vector<int> side;    // by point: −1 = left of the wound, 1 = right
  double along = 0;         // arc length of its middle on the wound's path [m]
  Vec3d middle, across;     // point of the path, and unit vector from left to right, lattice frame [m] [1]
  double gap = 0;           // distance of the lips in the CT; 0 = a cut [m]
  std::vector<EmbeddedPoint> at;  // by point
  EmbeddedPair lips;              // skin of both lips at `middle`

  StitchPhase phase = StitchPhase::kWaiting;
  double length = 0;      // stress-free length of the loop; 0 = the tension is prescribed [m]
  double before = 0;      // length of the loop when pulling began [m]
  double tension = 0;     // [N]
  double multiplier = 0;  // part of the tension that is kept from step to step [N]
  double ended = 0;       // time at which it pulled out or broke [s]
};

/// Two points of the walls that coincide in the CT, or that lie opposite each other in an excised wound.
struct WallPair {
  Vec3d rest, normal;  // middle, lattice frame [m]; unit normal from the left wall to the right one
  double gap = 0;      // distance in the CT [m]
  double along = 0;    // arc length on the wound's path [m]
  EmbeddedPair at;
  double force = 0;       // of each wall on the other [N]
  double multiplier = 0;  // part of the force that is kept from step to step [N]
};

/// Pulling of the stitches until they are knotted.
struct Pull {
  bool until_closed = true;  // until the lips meet under the stitch; otherwise with a tension
  double tension = 0;        // at the end of the pull [N]
  double start = 0;          // [s]
  double duration = 0.5;     // of a pull to `tension`, or to the length of the loop in the CT [s]
};

/// Layout of a row of stitches.
struct StitchLayout {
  double spacing = 0.01;                    // along the wound [m]
  double bite = 0.005;                      // from the wound to the points on each side [m]
  double depth = 0.002;                     // of the deep strand below the skin [m]
  std::vector<std::vector<Vec3d>> through;  // instead: points of single stitches, lattice frame [m]
};

/// Stitches of a wound, and the contact of its walls.
struct WoundClosure {
  Thread thread;
  double pull_out = 0;  // force on one point at which the tissue tears [N]
  std::vector<Stitch> stitches;
  std::vector<WallPair> walls;
  std::size_t version = 0;  // cut_version of the embedded points
  bool settled = false;     // all stitches are knotted, and no force changes any more
};

/// Lays stitches across a wound that was cut along a path. Errors: a point of a stitch is in air.
Result<WoundClosure> lay_stitches(const Model& model, const Cuts& cuts, const BladePath& path,
                                  const StitchLayout& layout);
/// Embeds all points again after a cut. Returns false if a point of a stitch lost its tissue.
bool embed_closure(const Model& model, const Cuts& cuts, WoundClosure& closure);

/// Pulls stitches and ties knots, before the step that ends at a time [s].
void pull_stitches(const Motion& motion, const Pull& pull, double time, WoundClosure& closure);

/// Length of the loop at the present positions, and in the CT with the lips together [m].
double loop_length(const Stitch& stitch, const Motion& motion);
double rest_length(const Stitch& stitch);
/// Opening of the wound under a stitch [m]; 0 without lips.
double gape_under(const Stitch& stitch, const Motion& motion);
/// Forces of the thread on the points of a stitch [N], lattice frame. Their sum is zero.
std::vector<Vec3d> stitch_forces(const Stitch& stitch, const Motion& motion);
/// Force with which the stitches pull the left lip to the right, less the pressure of the walls [N].
double closing_force(const WoundClosure& closure, const Motion& motion);

/// Appends the springs of a closure: those of the stitches that bear, then those of the walls. Without such
/// a stitch there are none.
void append_springs(const WoundClosure& closure, std::vector<PointSpring>& springs);
/// Updates the multipliers of a closure, and its springs, from the present positions.
void update_springs(const Model& model, const Motion& motion, WoundClosure& closure,
                    std::span<PointSpring> springs);
std::size_t spring_count(const WoundClosure& closure);

/// After a step: moves the multipliers towards the thread's law and closed walls.
void update_multipliers(const Model& model, const Motion& motion, WoundClosure& closure);
/// Ends stitches whose thread or tissue yields at the end of a step.
void end_overloaded_stitches(const Motion& motion, double time, WoundClosure& closure);

}  // namespace turgor::lattice
