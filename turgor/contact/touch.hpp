// One haptic tick: contact sites between tools and a patch, contact forces, and the displacement of the
// patch. Poses are input, forces are output. No memory is allocated. Time enters only through
// friction anchors and viscosity.
//
//   find_sites   points of the last tick's surface that a tool touches or may touch in this tick,
//                and positions inside triangles that are larger than the tool             (sites.hpp)
//   solve        contact forces                                                           (coulomb.hpp)
//   u = Ξ f      displacement of all points, and the viscous memory                       (viscosity.hpp)
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "turgor/contact/coulomb.hpp"
#include "turgor/contact/needle.hpp"
#include "turgor/contact/sites.hpp"
#include "turgor/contact/tool.hpp"
#include "turgor/contact/viscosity.hpp"
#include "turgor/models/sfem/patch.hpp"

namespace turgor::contact {

struct Tool {
  Shape shape;
  double friction = 0.3;              // Coulomb's μ [1]
  std::optional<Needle> needle = {};  // has no contact sites: needle_touch.hpp solves it; `shape` is its tip
};

struct ToolPose {
  Pose pose;
  bool hold = false;  // true: the tool carries the tissue that it touched when `hold` became true
};

/// Force on a tool.
struct ToolForce {
  Vec3d force;                     // [N]
  Vec3d torque;                    // about the tool's origin [N·m]
  int contacts = 0;                // number of sites that bear force
  int sliding = 0;                 // number of those that slide
  double largest_penetration = 0;  // largest depth of a patch point inside the tool after the tick [m]
  double area = 0;                 // rest area of the sites that bear force [m²]
  int level = 0;                   // level of its sites: see Site::level
  int dropped =
      0;  // number of touched sites beyond the capacity at the coarsest level; their force is missing
  bool invalid_pose = false;  // not finite or not a rotation: no contact in this tick
  bool inside = false;        // the tool appeared inside the body; it has no contact until it is outside
  bool beyond_patch = false;  // the contact reaches the border of the patch: a larger patch is needed
};

struct TouchParams {
  int capacity = 32;  // largest number of sites of all tools together; wide contacts use clusters of points
  double tool_softness =
      1e-5;  // compliance added to every site, relative to the softest point's compliance [1]
  Prony viscosity;
  // Limits the solver to half a millisecond if the contact jams and all sites are in use. The result is then
  // that of the last sweep, which satisfies the friction law at every site.
  FrictionalContactParams solver{.newton_steps = 6};
};

/// State of one tool that is kept between ticks.
struct ToolMemory {
  Pose pose;              // of the last tick
  bool seen = false;      // true after the first valid pose
  bool inside = false;    // see ToolForce
  bool touching = false;  // true if the tool bore force in the last tick
  int level = 0;          // level of its sites: see Site::level
};

/// Force jump of the latest changes of patch that is not yet blended out (patch_follow.hpp).
struct RemainingJump {
  Vec3d force;           // [N]
  Vec3d torque;          // [N·m]
  double reference = 0;  // norm of the force on the new patch at the change; below it, the added jump is
                         // reduced in proportion [N]
};

/// Workspace of a change of patch, kept so that the change does not allocate (patch_follow.hpp).
struct PatchMatch {
  std::vector<int> from_order, to_order;  // point indices sorted by PatchPoint::key
  std::vector<int> new_point, old_point;  // index of the same point in the other patch; -1 = none
  std::vector<Vec3d> offset, history;     // TouchState::offset and PairHistory::v of the new patch [m]
  std::vector<ToolForce> forces;          // on the old patch
};

/// State of a touch.
struct TouchState {
  TouchParams params;
  PatchSurface surface;
  std::vector<Vec3d> x;        // position of each point after the last tick [m]
  std::vector<Vec3d> u;        // displacement of each point by contact forces, including viscous memory [m]
  std::vector<Vec3d> outward;  // at each point after the last tick, not normalized
  std::vector<Vec3d> force;    // on each point [N]
  std::vector<Vec3d>
      offset;  // displacement of each point without contact forces; set by the caller, zero by default [m]
  ViscousHistory history;
  std::vector<Site> sites;  // of the last tick; the held ones first
  int held = 0;
  std::vector<ToolMemory> tools;
  std::vector<RemainingJump> remaining_jumps;  // of each tool
  std::vector<ToolPose> poses;                 // of the last tick
  std::vector<ToolForce> forces;               // of the last tick
  FrictionalContactReport solution;            // of the last tick

  FrictionalContactProblem problem;  // workspace of a tick, as are the next two members
  std::vector<Site> new_sites;
  PatchMatch match;
};

/// Touch state at rest. Reserves memory for later patches of up to `largest_patch` points.
TouchState make_touch_state(const sfem::Patch& patch, std::size_t tool_count, const TouchParams& params,
                            std::size_t largest_patch = 0);

/// Solves one tick of `dt` seconds, with one pose and one force per tool. A tick of 0 s repeats the last one.
void solve_touch_tick(const sfem::Patch& patch, TouchState& state, std::span<const Tool> tools,
                      std::span<const ToolPose> poses, double dt, std::span<ToolForce> forces);

/// Displaces the points of a patch by the forces of the sites. This stage of a tick follows the contact
/// solution.
void move_points(const sfem::Patch& patch, const ViscousTick& viscous, TouchState& state);

/// Contact pressure at every point [Pa]: force along the normal at rest, divided by the area around the
/// point.
void contact_pressure(const PatchSurface& surface, std::span<const Vec3d> force, std::span<double> pressure);

/// Depth of a tool's deepest point below the surface of a patch at rest; 0 = no contact [m].
double depth_at_rest(const sfem::Patch& patch, const PatchSurface& surface, const Shape& shape,
                     const Pose& pose);

}  // namespace turgor::contact
