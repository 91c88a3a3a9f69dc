// Bodies whose forces are known once a frame, felt in every tick. A frame leaves what it found at a tool as a
// plane with a stiffness, a LocalContact; a tick couples the tool to a proxy on the newest one by springs, so
// that the force follows the hand between two frames [Adachi, Kumano, Ogino 1995: intermediate
// representation; Colgate, Stanley, Brown 1995: virtual coupling]. The plane pushes and never pulls, and the
// proxy slides where friction does not hold it.
//
//   the frame        local_contact(a lattice or a cloth after its step)   → latest<LocalContact>
//   who ticks        take(touch, the newest) when there is one, then tick
//
// With the tool where the frame had it, the force is the frame's own. What a new plane changes is blended in.
#pragma once

#include "turgor/contact/lattice_touch.hpp"
#include "turgor/contact/tool_io.hpp"
#include "turgor/contact/touch.hpp"
#include "turgor/models/cloth/model/cloth.hpp"

namespace turgor::contact {

/// What a frame knows of the tissue at one tool. Everything in the world.
struct LocalContact {
  bool is_near = false;        // false: nothing is within reach of the tool
  bool is_held = false;        // the tool holds what it touches, which pulls as well
  Vec3d origin;                // of the tool, when all this was so [m]
  Vec3d normal{0, 0, 1};       // unit, from the tissue at the tool
  Vec3d force;                 // on the tool [N]
  Vec3d arm;                   // from the tool's origin to where the force acts [m]
  double gap = 0;              // how far the tool is from touching; 0 while it does [m]
  double stiffness = 0;        // along the normal [N/m]
  double shear_stiffness = 0;  // across it [N/m]
  double friction = 0;         // Coulomb's μ [1]
  double reach = 0;            // the plane is known for the tissue so far from `origin` [m]
  long number = 0;             // of the planes of this tool so far
  int teleports = 0;           // how often the tool had been put elsewhere by then
};

struct LocalTouchParams {
  double blend_time = 0.03;    // what a new plane changes comes in with this time constant [s]
  double largest_step = 0.02;  // and by at most this much a tick [N]
  double damping = 0.5;  // of the coupling: by so much of itself the force grows per speed inwards [s/m]
};

/// What who ticks owns, of one tool.
struct LocalTouch {
  LocalTouchParams params;
  LocalContact contact;
  Vec3d proxy;              // where the tool's origin would be if nothing rubbed [m]
  Vec3d rest;               // of the force before the newest plane, not yet blended away [N]
  double reference = 0;     // the plane's own push when it was taken; with less, less of `rest` is left [N]
  bool seen = false;        // there is a last tick, and this is of it:
  Vec3d position, force;    // [m] [N]
  double largest_jump = 0;  // of all new planes, before blending [N]
};

/// A newer plane, between two ticks.
void take(LocalTouch& touch, const LocalContact& contact);
/// One tick of `dt` seconds. Neither allocates nor waits.
void tick(LocalTouch& touch, const ToolCommand& command, double dt, ToolReading& reading);

/// What the frame remembers of one tool from one step to the next: stiffness is what the force changed by
/// where the tool went.
struct LocalMemory {
  bool seen = false;
  Vec3d position;        // of the tool [m]
  double pressing = 0;   // [N]
  double gap = 0;        // [m]
  double stiffness = 0;  // the newest that was measured; 0 = none yet [N/m]
};
/// After a step of a lattice (contact::step) that took the tool to `pose` [patient frame].
LocalContact local_contact(const lattice::Model& model, const lattice::State& state,
                           const LatticeTouch& touch, int tool_index, const Tool& tool, const ToolPose& pose,
                           LocalMemory& memory);
/// After a step of `dt` seconds of a cloth in which the tool was its obstacle of this number, `gap` away from
/// it (cloth_obstacle.hpp), and went to `pose`.
LocalContact local_contact(const cloth::Model& model, const cloth::State& state, int obstacle, double gap,
                           const Tool& tool, const Pose& pose, double dt, LocalMemory& memory);

}  // namespace turgor::contact
