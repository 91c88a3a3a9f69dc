// Patches that follow the tools: criterion for a new patch, transfer of the touch state to it, and blending
// of the force jump that the transfer causes. The caller builds the patch and chooses the thread that does
// so.
#pragma once

#include <span>
#include <vector>

#include "turgor/contact/touch.hpp"

namespace turgor::contact {

struct FollowParams {
  double radius = 0.02;        // of the patch [m]
  double hysteresis = 0.25;    // distance between touch and patch center that triggers a new patch, as a
                               // fraction of `radius` [1]
  double blend_time = 0.05;    // time constant with which a force jump decays [s]
  double largest_step = 0.02;  // largest change of the force by blending per tick [N]
};

/// Force-weighted center of a tool's contacts, on the body at rest.
struct ContactCenter {
  Vec3d position;  // [m]
  bool touches = false;
};
/// Contact centers of all tools. Does not allocate.
void find_contact_centers(const sfem::Patch& patch, const TouchState& state,
                          std::span<ContactCenter> contact_centers);

/// Touched position of every tool on the body at rest: the center of its contacts, or the nearest point of
/// the coarse surface without contact. A tool without a valid pose keeps its entry of `before`; without such
/// an entry it gets the body's first vertex.
std::vector<Vec3d> touched_positions(const sfem::Model& model, std::span<const ContactCenter> contact_centers,
                                     std::span<const ToolPose> poses, std::span<const Vec3d> before = {});

/// True when a touch is too far from the center of the present patch.
bool must_follow(const FollowParams& params, std::span<const Vec3d> centers,
                 std::span<const Vec3d> positions);

/// Change of the tool forces by a new patch, at unchanged poses.
struct Handover {
  double force_jump = 0;   // largest jump of all tools, before blending [N]
  double torque_jump = 0;  // [N·m]
  int shared_points = 0;   // number of points that are in both patches
};

/// Viscous memory as forces on coarse vertices, prepared for the next patch. Empty for elastic
/// material.
struct TransferredHistory {
  struct Pair {
    std::vector<Vec3d> v;          // displacement of the new patch's points under `far` [m]
    std::vector<VertexForce> far;  // coarse_history of the old patch
  };
  std::vector<Pair> pairs;  // those in use
};
/// Viscous memory of `from`, evaluated at the points of `to`.
TransferredHistory transferred_history(const sfem::Model& model, const ViscousHistory& history,
                                       const sfem::Patch& from, const sfem::Patch& to);

/// Transfers the touch state from one patch to the next. Forces stay at points that are in both patches;
/// other forces move to the nearest point. Held points keep their anchors. Does not allocate if the new patch
/// has at most make_touch_state's `largest_patch` points and the history fits its reserved size.
Handover take_patch(TouchState& state, const sfem::Patch& from, const sfem::Patch& to,
                    std::span<const Tool> tools, const TransferredHistory& history = {});

/// Adds the remaining force jumps to this tick's forces and reduces them.
void blend(const FollowParams& params, TouchState& state, double dt, std::span<ToolForce> forces);

}  // namespace turgor::contact
