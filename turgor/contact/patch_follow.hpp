// The patch follows the tools: when it must, what a new one takes over from the old one, and how the jump of
// the force that this makes is measured and spread over time. Who builds the new patch, and on which thread,
// is the caller's choice.
#pragma once

#include <span>
#include <vector>

#include "turgor/contact/touch.hpp"

namespace turgor::contact {

struct FollowParams {
  double radius = 0.02;        // of the patch [m]
  double hysteresis = 0.25;    // how far a touch may wander from where the patch was centred [radius]
  double blend_time = 0.05;    // a jump of the force dies away with this time constant [s]
  double largest_step = 0.02;  // and by at most this much a tick [N]
};

/// The middle of what a tool touches, on the body at rest, weighted by force.
struct ContactMiddle {
  Vec3d place;  // [m]
  bool touches = false;
};
/// One a tool; allocates nothing.
void find_middles(const sfem::Patch& patch, const TouchState& state, std::span<ContactMiddle> middles);

/// Where every tool touches the body at rest, or would: the middle of its contacts, or the nearest place of
/// the coarse surface. A tool without a valid pose has its entry of `before`, or the body's first vertex.
std::vector<Vec3d> touched_places(const sfem::Model& model, std::span<const ContactMiddle> middles,
                                  std::span<const ToolPose> poses, std::span<const Vec3d> before = {});

/// Has a touch wandered from where the present patch was centred?
bool must_follow(const FollowParams& params, std::span<const Vec3d> centers, std::span<const Vec3d> places);

/// What a new patch did to the forces, with the tools where they were.
struct Handover {
  double force_jump = 0;   // largest over the tools, before blending [N]
  double torque_jump = 0;  // [N·m]
  int kept_points = 0;     // in both patches
};

/// What viscous material remembers beyond the patch, for one that is to be taken. Both are empty when it is
/// elastic.
struct HandedHistory {
  std::vector<Vec3d> v;          // displacements of the new points by `far` (viscosity.hpp) [m]
  std::vector<VertexForce> far;  // coarse_history of the patch before
};
HandedHistory handed_history(const sfem::Model& model, const ViscousHistory& history, const sfem::Patch& from,
                             const sfem::Patch& to);

/// Carries the state from one patch to the next: forces stay at points that are in both, the others move to
/// the nearest; held points stay where they are held. Allocates nothing when the new patch is within
/// make_touch_state's `largest_patch`, and the history within what the state has reserved.
Handover take_patch(TouchState& state, const sfem::Patch& from, const sfem::Patch& to,
                    std::span<const Tool> tools, const HandedHistory& history = {});

/// Adds what is left of the jumps to this tick's forces, and lets it shrink.
void blend(const FollowParams& params, TouchState& state, double dt, std::span<ToolForce> forces);

}  // namespace turgor::contact
