// Haptic touch of an sfem body, split between two threads. Neither thread waits for the other: they exchange
// complete values through latest<> (core/latest.hpp), and only the newest value is read.
//
//   haptic thread                owns SfemTouch; only tick_*, take_free_motion and take_patch change it
//      publishes each tick       SfemTouchSnapshot → the frame rotates and draws the body, reads tool poses
//                                LawForces         → the nonlinear patch is solved for them
//   frame (pictures, patches)    owns the rest of the body
//      publishes each frame      FreeMotion        → take_free_motion: motion of the vertices without tools
//      publishes when built      FinishedPatch        → take_patch: a patch at the tools' present positions
//   solver of a nonlinear patch  owns its displacement (sim/bodies/sfem/law_solver.hpp)
//      publishes when solved     PatchSolution     → take_solution: the same points, linearized again
//
// A patch and its sfem::Model are read-only while in use. Without a haptic device one thread calls all of
// these functions in turn (sim/bodies/sfem/touch_sfem.cpp). The same tool path then gives the same bits.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "turgor/contact/free_motion.hpp"
#include "turgor/contact/needle_touch.hpp"
#include "turgor/contact/patch_follow.hpp"
#include "turgor/contact/texture.hpp"
#include "turgor/contact/tool_io.hpp"
#include "turgor/contact/touch.hpp"
#include "turgor/core/latest.hpp"

namespace turgor::contact {

/// State owned by the haptic thread.
struct SfemTouch {
  std::shared_ptr<const sfem::Patch> patch;
  std::vector<Tool> tools;
  FollowParams follow;
  double stiffness_scale = 1;  // present stiffness divided by the patch's stiffness; scales all forces [1]
  TouchState state;
  FreeMotionInterpolation free;
  long patch_number = 0;               // FinishedPatch::number of `patch`
  long solution_tick = 0;              // PatchSolution::tick of `patch`; 0: as it was built
  long motion_number = 0;              // FreeMotion::number of the newest motion
  long ticks = 0;                      // number of ticks so far
  Handover handover;                   // of the last change of patch
  std::vector<ToolPose> poses;         // of the last tick
  std::vector<ToolForce> forces;       // of the last tick, with more detail than ToolReading
  NeedleTouch needles;                 // of tools that are needles
  double stiffening = 0;               // of the law of a nonlinear patch (sfem::Law), for its solver [1]
  Texture texture;                     // of the body
  std::vector<TextureState> textures;  // of each tool
  std::vector<Vec3d> tools_before;     // origins of the tools before the present tick [m]
  double free_step = 0;                // fraction of the free motion that the present tick made [1]
};

struct SfemTouchParams {
  TouchParams touch;
  FollowParams follow;
  std::size_t vertex_count = 0;  // of the body's mesh
  Texture texture = {};
};
/// Touch state at rest. Reserves memory for later patches of twice the points.
SfemTouch make_sfem_touch(std::shared_ptr<const sfem::Patch> patch, std::vector<Tool> tools,
                          std::span<const Pose> poses, const SfemTouchParams& params);

/// Tick of `dt` seconds with one command and one reading per tool. Does not allocate or wait.
void tick_sfem_touch(SfemTouch& touch, std::span<const ToolCommand> commands, double dt,
                     std::span<ToolReading> readings);

/// Changes the pairs between two ticks. Does not allocate after reserve_viscosity.
void set_viscosity(SfemTouch& touch, const Prony& viscosity);
/// Reserves memory for all pairs, of later patches too.
void reserve_viscosity(SfemTouch& touch);

/// Starts an interpolation of the free motion from its present value to `to` over `ticks` ticks [m]. Does
/// nothing if `to` is empty.
void take_free_motion(SfemTouch& touch, std::span<const Vec3d> to, long ticks);

/// The same for the motion of the vertices around each needle that is not caused by that needle; one list a
/// tool.
void take_needle_motion(SfemTouch& touch, std::span<const std::vector<Vec3d>> to, long ticks);
/// Needles of a touch, with the Green's functions around them. Reserves memory for those of all of the body's
/// vertices.
void add_needles(SfemTouch& touch, std::shared_ptr<const sfem::InnerGreen> inner);
/// Replaces the Green's functions around the needles between two ticks. They contain the elements of all
/// tracks; a track that is not contained is forgotten. Motions go on, and those of new vertices begin at
/// `to`, the motions for take_needle_motion of these Green's functions. Does not allocate.
void take_inner(SfemTouch& touch, const std::shared_ptr<const sfem::InnerGreen>& inner,
                std::span<const std::vector<Vec3d>> to);

/// A finished patch. Its builder keeps a reference until it holds the last one, because the haptic thread
/// must not free memory.
struct FinishedPatch {
  std::shared_ptr<const sfem::Patch> patch;
  TransferredHistory history;
  long number = 0;  // counted from 1
};
/// Replaces the patch between two ticks. Allocates only if take_patch of patch_follow.hpp does.
Handover take_patch(SfemTouch& touch, const FinishedPatch& offer);

/// Forces on a nonlinear patch after a tick, published for its solver.
struct LawForces {
  long patch_number = 0, solution_tick = 0;  // as in SfemTouch
  long ticks = 0;                            // number of ticks so far
  std::vector<Vec3d> force;                  // on the points, at a stiffness_scale of 1 [N]
  double stiffening = 0;                     // see SfemTouch
};
/// A nonlinear patch linearized at the solution for forces of LawForces. Its solver keeps a reference until
/// it holds the last one.
struct PatchSolution {
  std::shared_ptr<const sfem::Patch> patch;
  long base = 0;  // FinishedPatch::number of the patch that was solved
  long tick = 0;  // LawForces::ticks of the forces; positive
};
/// Replaces the patch by its solution between two ticks; a solution of another patch is ignored. Does not
/// allocate, because the points are the same.
void take_solution(SfemTouch& touch, const PatchSolution& solution);

/// Snapshot published for the frame.
struct SfemTouchSnapshot {
  std::shared_ptr<const sfem::Patch> patch = std::make_shared<const sfem::Patch>();  // empty without tools
  long patch_number = 0;  // FinishedPatch::number of `patch`
  long ticks = 0;         // number of ticks so far
  double force_jump = 0;  // of the last change of patch, before blending [N]
  std::vector<Vec3d> x,
      force;  // of the patch's points: position [m], and force at a stiffness_scale of 1 [N]
  ViscousHistory history;
  Prony viscosity;
  double stiffness_scale = 1;  // see SfemTouch
  std::vector<ToolPose> poses;
  std::vector<ToolForce> forces;
  std::vector<ContactCenter> contact_centers;
  std::shared_ptr<const sfem::InnerGreen> inner;  // NeedleTouch::inner
  std::vector<std::vector<Vec3d>>
      needle_forces;                // of each tool, on the vertices of `inner`, at a stiffness_scale of 1 [N]
  std::vector<int> track_elements;  // elements of the mesh that all tracks pass, in any order
  std::vector<TextureState> textures;  // of each tool
};
/// Fills a snapshot. Does not allocate after reserve_like.
void publish(const SfemTouch& touch, SfemTouchSnapshot& now);
void reserve_like(const SfemTouch& touch, SfemTouchSnapshot& now);

/// Free motion of all vertices in the next frame, and changed parameters.
struct FreeMotion {
  std::vector<Vec3d> to;                       // target displacement of every vertex; empty = no motion [m]
  long ticks = 1;                              // duration of that frame [ticks of 1 ms]
  double stiffness_scale = 1;                  // see SfemTouch
  std::vector<double> friction;                // one per tool; empty = unchanged
  Waves waves;                                 // of the body's texture
  std::optional<Prony> viscosity;              // of the body; empty = unchanged
  std::optional<double> stiffening;            // see SfemTouch; empty = unchanged
  std::vector<std::vector<Vec3d>> of_needles;  // of each tool: target of NeedleState::motion; empty = none
  std::shared_ptr<const sfem::InnerGreen>
      inner;        // of needles; the sender keeps a reference until it has the last
  long number = 0;  // number of motions published
};

/// Channels between the haptic thread and the frame thread.
struct SfemExchange {
  latest<SfemTouchSnapshot> touched;  // written by the haptic thread
  latest<FreeMotion> motion;          // written by the frame thread, as is the next
  latest<FinishedPatch> patches;
  latest<LawForces> forces;         // written by the haptic thread if is_solved
  latest<PatchSolution> solutions;  // written by the solver
  bool is_solved = false;           // true: a solver reads the forces
};
/// Reserves the buffers of all channels. Call it before the threads start.
void prepare(const SfemTouch& touch, SfemExchange& exchange);
/// Tick of the haptic thread: takes the newest motion, patch and solution, ticks, and publishes a snapshot.
/// Does not allocate or wait. The frame thread's counterpart is make_frame in sim/bodies/sfem/sfem_body.hpp.
void tick_with_exchange(SfemTouch& touch, SfemExchange& exchange, std::span<const ToolCommand> commands,
                        double dt, std::span<ToolReading> readings);

}  // namespace turgor::contact
