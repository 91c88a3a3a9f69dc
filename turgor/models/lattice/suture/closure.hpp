// Stitches that close a wound. A stitch is a loop of thread through points of the tissue, along which it
// slides without friction. Its energy is that of a unilateral spring of the whole loop. In a running suture
// one thread makes all stitches, and slides from one to the next against friction (running.cpp). Opposite
// points of the wound's walls do not pass each other. While they are pulled and until the forces rest, all
// are coupled by multipliers that follow from step to step (augmented Lagrangian), so that a stiff thread
// does not slow the sweeps down. These multipliers follow late, and a body that moves would gain energy from
// them. A closure that has come to rest therefore has springs instead, with the same forces: it returns no
// more energy than it was given.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
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
  double friction = 0;   // Coulomb coefficient in tissue, between the stitches of a running suture [1]
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
  bool is_open = false;     // a stitch of a running suture, which ends at the first point of the next one
  bool keeps_bites =
      false;             // the two points on one side move as one: the tissue between them keeps its length
  double along = 0;      // arc length of its middle on the wound's path [m]
  Vec3d middle, across;  // point of the path, and unit vector from left to right, lattice frame [m] [1]
  double gap = 0;        // distance of the lips in the CT; 0 = a cut [m]
  double shortest = 0;   // length of the loop beyond which pulling would crush the tissue [m]
  std::vector<EmbeddedPoint> at;  // by point; of bites that move as one: their middle
  EmbeddedPair lips;              // skin of both lips at `middle`

  StitchPhase phase = StitchPhase::kWaiting;
  double length = 0;      // stress-free length of the loop; 0 = the tension is prescribed [m]
  double before = 0;      // length of the loop when pulling began [m]
  double tension = 0;     // [N]
  double multiplier = 0;  // part of the tension that is kept from step to step [N]
  double ended = 0;       // time at which it pulled out or broke [s]
};

/// Two points that do not pass each other: points of the walls that coincide in the CT, or that lie opposite
/// each other in an excised wound; or the ends of the rim between a bite of a stitch and its lip, which may
/// become as short as skin without tension.
struct WallPair {
  Vec3d rest, normal;  // middle, lattice frame [m]; unit normal from the left point to the right one
  double gap = 0;      // distance that they may approach each other since the CT [m]
  double along = 0;    // arc length on the wound's path [m]
  int stitch = -1;     // of a rim; −1 = walls
  int point = 0;       // of a rim: first point of the bite; the other end is the lip at `rest`
  EmbeddedPair at;
  double force = 0;       // of each wall on the other [N]
  double multiplier = 0;  // part of the force that is kept from step to step; constant once settled [N]
};

/// Pulling of the stitches until they are knotted.
struct Pull {
  bool until_closed = true;  // until the lips meet under the stitch; otherwise with a tension
  double from = 0;           // tension at the start of a pull to `tension` [N]
  double tension = 0;        // at the end of the pull [N]
  double start = 0;          // [s]
  double duration = 0.5;     // of a pull to `tension`, or to the length of the loop in the CT [s]
};

/// Layout of a row of stitches.
struct StitchLayout {
  double spacing = 0.01;                    // along the wound [m]
  double bite = 0.005;                      // from the wound to the points on each side [m]
  double depth = 0.002;                     // of the deep strand below the skin [m]
  bool is_running = false;                  // one thread makes all stitches
  std::vector<std::vector<Vec3d>> through;  // instead: points of single stitches, lattice frame [m]
};

/// Stitches of a wound, and the contact of its walls.
struct WoundClosure {
  Thread thread;
  double pull_out = 0;  // force on one point at which the tissue tears [N]
  std::vector<Stitch> stitches;
  std::vector<WallPair> walls;  // and rims
  bool is_running = false;      // one thread makes all stitches
  std::size_t version = 0;      // cut_version of the embedded points
  bool settled = false;         // all stitches are knotted, and their forces came to rest: they are springs
};

/// Lays stitches across a wound that was cut along a path. Errors: a point of a stitch is in air.
Result<WoundClosure> lay_stitches(const Model& model, const Cuts& cuts, const BladePath& path,
                                  const StitchLayout& layout);
/// Distance of the middle of points, lattice frame, from the line of a wound [m]. Empty: no two of them lie
/// on different sides of it.
std::optional<double> distance_to_wound(const BladePath& path, std::span<const Vec3d> points);
/// Embeds all points again after a cut. Returns false if a point of a stitch lost its tissue.
bool embed_closure(const Model& model, const Cuts& cuts, WoundClosure& closure);

/// Pulls stitches and ties knots, before the step that ends at a time [s].
void pull_stitches(const Motion& motion, const Pull& pull, double time, WoundClosure& closure);

/// Opens the knots of the stitches that bear, for another pull. Their tensions stay until it starts.
void untie_stitches(const Motion& motion, WoundClosure& closure);

/// Length of the loop at the present positions, and in the CT with the lips together [m]. Bites that keep
/// their length have that of the CT.
double loop_length(const Stitch& stitch, const Motion& motion);
double rest_length(const Stitch& stitch);
/// Length of thread without stress in all stitches that bear [m].
double thread_length(const WoundClosure& closure);
/// Opening of the wound under a stitch [m]; 0 without lips.
double gape_under(const Stitch& stitch, const Motion& motion);
/// Forces of the thread on the points of a stitch [N], lattice frame. Their sum is zero.
std::vector<Vec3d> stitch_forces(const Stitch& stitch, const Motion& motion);
/// Force with which the stitches pull the left lip to the right [N].
double thread_force(const WoundClosure& closure, const Motion& motion);
/// The same, less the pressure of the walls [N].
double closing_force(const WoundClosure& closure, const Motion& motion);
/// True if a stitch bears.
bool bears(const WoundClosure& closure);

/// Appends the springs of a closure: those of the stitches that bear, then those of the walls. Without such
/// a stitch there are none.
void append_springs(const WoundClosure& closure, std::vector<PointSpring>& springs);
/// Updates tensions and wall forces, and the springs that apply them, from the present positions.
void update_springs(const Model& model, const Motion& motion, WoundClosure& closure,
                    std::span<PointSpring> springs);
std::size_t spring_count(const WoundClosure& closure);

/// Elastic energy of the threads that follow their law, and of the walls and rims of a settled closure [J].
double stored_energy(const Model& model, const Motion& motion, const WoundClosure& closure);

/// Contact between the walls of the wound [N]: the sum over all pairs but rims.
double wall_force(const WoundClosure& closure);
/// Removes the walls of a wound, but no rims.
void remove_walls(WoundClosure& closure);
/// Leaves the walls of a wound to one of its closures: to one that bears, if any does. They keep their forces
/// when the closure that had them ends.
void share_walls(const Model& model, const Motion& motion, std::span<WoundClosure* const> of_wound);

/// Turning of the thread between the deep strands of two successive stitches of a running suture [rad].
double turning_between(const Stitch& from, const Stitch& to, const Motion& motion);
/// Slides thread of a running suture to the stitch with the larger tension until the tensions of neighbors
/// differ by at most exp(μ θ). Keeps the length of all thread. Returns the largest change of a tension [N].
double slide_thread(const Model& model, const Motion& motion, WoundClosure& closure);
/// Ends each stitch of a running suture at the first point of the next one that did not end, the last one at
/// its own.
void join_stitches(WoundClosure& closure);
/// Gives the thread of a stitch that tore out to its neighbors.
void free_thread(WoundClosure& closure, std::size_t torn);

/// After a step: moves the multipliers towards the thread's law and closed walls, and slides a running
/// thread. A closure whose forces rest gets springs.
void update_multipliers(const Model& model, const Motion& motion, WoundClosure& closure);
/// Ends stitches whose thread or tissue yields at the end of a step. A running suture breaks as a whole. The
/// walls keep their forces for share_walls.
void end_overloaded_stitches(const Motion& motion, double time, WoundClosure& closure);

}  // namespace turgor::lattice
