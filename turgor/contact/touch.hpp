// One haptic tick: where tools touch the surface of a patch, which forces keep them apart, and how the patch
// moves. Poses go in, forces come out; nothing is allocated, and time enters through friction's memory and
// viscosity alone.
//
//   find_sites   points (and places inside triangles, for tools smaller than those) that a tool touches or
//   may
//                touch in this tick, as the surface lies after the last one       (sites.hpp)
//   solve        the forces                                                       (coulomb.hpp)
//   u = Ξ f      of all points, and what the material remembers                   (viscosity.hpp)
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "turgor/contact/coulomb.hpp"
#include "turgor/contact/sites.hpp"
#include "turgor/contact/tool.hpp"
#include "turgor/contact/viscosity.hpp"
#include "turgor/models/sfem/patch.hpp"

namespace turgor::contact {

struct Tool {
  Shape shape;
  double friction = 0.3;  // Coulomb's μ [1]
};

struct ToolPose {
  Pose pose;
  bool hold = false;  // what is touched when this begins is carried with the tool until it ends
};

/// On a tool.
struct ToolForce {
  Vec3d force;                     // [N]
  Vec3d torque;                    // about the tool's origin [N·m]
  int contacts = 0;                // sites that bear force
  int sliding = 0;                 // those of them that slide
  double largest_penetration = 0;  // of a point after the tick [m]
  double area = 0;                 // around the sites that bear force, at rest [m²]
  int level = 0;                   // how coarse its sites are: see Site::level
  int dropped = 0;                 // touched sites that no level found room for: their force is missing
  bool invalid_pose = false;       // not finite or not a rotation: no contact in this tick
  bool inside = false;             // it appeared inside the body: no contact until it has come out
  bool beyond_patch = false;       // it touches the border of the patch: a larger patch is needed
};

struct TouchParams {
  int capacity = 32;            // sites of all tools together; wide contacts are taken by clusters of points
  double tool_softness = 1e-5;  // compliance of a site itself, as part of that of the softest point [1]
  Viscosity viscosity;
  // A jam of as many sites as there is room for is solved within half a millisecond; what is left unsolved
  // then is what the last sweep made of it, which every site's friction allows.
  FrictionalContactParams solver{.newton_steps = 6};
};

/// One tool between ticks.
struct ToolMemory {
  Pose pose;              // of the last tick
  bool seen = false;      // there is one
  bool inside = false;    // see ToolForce
  bool touching = false;  // it bore force in the last tick
  int level = 0;          // of its sites: see Site::level
};

/// What is left of the jumps that new patches made (patch_follow.hpp).
struct ForceRest {
  Vec3d force;   // [N]
  Vec3d torque;  // [N·m]
  double reference =
      0;  // force of the last tick on the patch that made the jump; with less, less is left [N]
};

/// Numbers that hold still between two patches, kept so that taking one allocates nothing (patch_follow.hpp).
struct PatchMatch {
  std::vector<int> from_order, to_order;  // points by key
  std::vector<int> new_point, old_point;  // the same point of the other patch; -1 = none
  std::vector<Vec3d> offset, history;     // [m]
  std::vector<ToolForce> forces;          // on the old patch
};

/// What changes.
struct TouchState {
  TouchParams params;
  PatchSurface surface;
  std::vector<Vec3d> x;        // points after the last tick [m]
  std::vector<Vec3d> u;        // of it, what forces made, now and before [m]
  std::vector<Vec3d> outward;  // at each point after the last tick, of any length
  std::vector<Vec3d> force;    // on each point [N]
  std::vector<Vec3d> offset;   // what no force of ours makes; zero unless the caller writes it [m]
  ViscousHistory history;
  std::vector<Site> sites;  // of the last tick; the held ones first
  int held = 0;
  std::vector<ToolMemory> tools;
  std::vector<ForceRest> rests;      // of each tool
  std::vector<ToolPose> poses;       // of the last tick
  std::vector<ToolForce> forces;     // of the last tick
  FrictionalContactReport solution;  // of the last tick

  FrictionalContactProblem problem;  // of use within a tick only
  std::vector<Site> new_sites;       // likewise
  PatchMatch match;                  // likewise
};

/// At rest. `largest_patch`: points that a later patch may have without an allocation.
TouchState make_touch_state(const sfem::Patch& patch, std::size_t tool_count, const TouchParams& params,
                            std::size_t largest_patch = 0);

/// One tick of `dt` seconds; a tick of 0 s repeats the last one. Poses and forces: one a tool.
void touch(const sfem::Patch& patch, TouchState& state, std::span<const Tool> tools,
           std::span<const ToolPose> poses, double dt, std::span<ToolForce> forces);

/// Puts the points of a patch where the forces of the sites push them: the part of a tick behind its
/// contacts.
void move_points(const sfem::Patch& patch, const ViscousTick& viscous, TouchState& state);

/// Contact pressure at every point: force along its normal at rest / area around it [Pa].
void contact_pressure(const PatchSurface& surface, std::span<const Vec3d> force, std::span<double> pressure);

/// How far the deepest point of a tool is below the surface of a patch at rest; 0 = it does not touch [m].
double depth_at_rest(const sfem::Patch& patch, const PatchSurface& surface, const Shape& shape,
                     const Pose& pose);

}  // namespace turgor::contact
