// A body of sfem while a hand feels it, cut apart where threads may be: no side waits for the other, and what
// one leaves for the other goes through latest<> (core/latest.hpp), whole, the newest only.
//
//   who ticks (a haptic thread)        owns SfemTouch: tick, take_frame and take_patch alone change it
//      leaves in each tick             TouchedNow  → the frame turns the body, draws it, sees where tools are
//   the frame (pictures, patches)      owns the rest of the body
//      leaves in each frame            FreeMotion  → take_frame: where the vertices go by themselves
//      leaves when one is built        PatchOffer  → take_patch: a patch where the tools are now
//
// sfem::Model and a patch are only read while they are in use. Where nobody holds a device the frame does all
// three in turn (sim/bodies/sfem/touch_sfem.cpp), and the same path gives the same bits.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "turgor/contact/patch_follow.hpp"
#include "turgor/contact/tool_io.hpp"
#include "turgor/contact/touch.hpp"
#include "turgor/core/latest.hpp"

namespace turgor::contact {

/// Where something else than tools moves every vertex, in the way from one frame to the next.
struct FreeWay {
  bool moves = false;
  std::vector<Vec3d> from, to;  // [m]
  long ticks = 1, done = 0;     // of the way
};

/// What who ticks owns.
struct SfemTouch {
  std::shared_ptr<const sfem::Patch> patch;
  std::vector<Tool> tools;
  FollowParams follow;
  double stiffer = 1;  // than its patch, at any place: so many times as large is every force
  TouchState state;
  FreeWay free;
  long taken = 0;                 // PatchOffer::number of the patch
  long frame = 0;                 // FreeMotion::number of the way
  long ticks = 0;                 // so far
  Handover handover;              // when it was taken
  std::vector<ToolPose> poses;    // of the last tick
  std::vector<ToolForce> forces;  // likewise, in more detail than ToolReading
};

struct SfemTouchParams {
  TouchParams touch;
  FollowParams follow;
  std::size_t vertex_count = 0;  // of the body's mesh
};
/// At rest. Later patches may have twice the points before taking them allocates.
SfemTouch make_sfem_touch(std::shared_ptr<const sfem::Patch> patch, std::vector<Tool> tools,
                          std::span<const Pose> poses, const SfemTouchParams& params);

/// One tick of `dt` seconds: commands in, readings out, one a tool. Neither allocates nor waits.
void tick(SfemTouch& touch, std::span<const ToolCommand> commands, double dt,
          std::span<ToolReading> readings);

/// From here the free motion of the vertices goes to `to` within so many ticks, from where it is [m]. Empty:
/// nothing has moved yet.
void take_frame(SfemTouch& touch, std::span<const Vec3d> to, long ticks);

/// A patch that may be taken. Whoever offers it keeps it alive until nobody else holds it: a haptic thread is
/// not to free memory.
struct PatchOffer {
  std::shared_ptr<const sfem::Patch> patch;
  HandedHistory history;
  long number = 0;  // offers count from 1
};
/// Between two ticks. Allocates nothing where patch_follow.hpp's take_patch does not.
Handover take_patch(SfemTouch& touch, const PatchOffer& offer);

/// What ticks leave for the frame.
struct TouchedNow {
  std::shared_ptr<const sfem::Patch> patch = std::make_shared<const sfem::Patch>();  // empty without tools
  long taken = 0;               // PatchOffer::number of it
  long ticks = 0;               // so far
  double force_jump = 0;        // that taking it made, before blending [N]
  std::vector<Vec3d> x, force;  // of its points [m]; as if `stiffer` were 1 [N]
  ViscousHistory history;
  double stiffening = 0;  // Viscosity::stiffening
  double stiffer = 1;     // see SfemTouch
  std::vector<ToolPose> poses;
  std::vector<ToolForce> forces;
  std::vector<ContactMiddle> middles;
};
/// Writes all of `now`; allocates nothing once reserve_like has seen it.
void publish(const SfemTouch& touch, TouchedNow& now);
void reserve_like(const SfemTouch& touch, TouchedNow& now);

/// Where the vertices go by themselves in the next frame: every one, or none; and what changed meanwhile.
struct FreeMotion {
  std::vector<Vec3d> to;         // [m]
  long ticks = 1;                // of that frame
  double stiffer = 1;            // see SfemTouch
  std::vector<double> friction;  // of every tool; empty: as it was
  long number = 0;               // of the motions so far
};

/// What passes between a haptic thread and the thread that makes frames and has patches built.
struct SfemExchange {
  latest<TouchedNow> touched;  // written by the haptic thread
  latest<FreeMotion> motion;   // written by the frame's, as the next
  latest<PatchOffer> patches;
};
/// Before either thread begins.
void prepare(const SfemTouch& touch, SfemExchange& exchange);
/// A tick of the haptic thread: takes what is new, ticks, leaves what the frame wants to know. Neither
/// allocates nor waits. The frame's side is make_frame of sim/bodies/sfem/sfem_body.hpp.
void tick(SfemTouch& touch, SfemExchange& exchange, std::span<const ToolCommand> commands, double dt,
          std::span<ToolReading> readings);

}  // namespace turgor::contact
