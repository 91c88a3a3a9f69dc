// Haptic forces of bodies that are solved once per frame. Each frame publishes a local contact for every
// tool: a tangent plane with a stiffness. In every tick springs couple the tool to a proxy on the newest
// plane, so that the force follows the hand between frames [Adachi, Kumano, Ogino 1995: intermediate
// representation; Colgate, Stanley, Brown 1995: virtual coupling]. The plane pushes and never pulls. The
// proxy slides when the shear force exceeds friction.
//
//   frame            local_contact(lattice or cloth after its step)        → latest<LocalContact>
//   haptic thread    update_contact(touch, newest) if there is one, then tick_local_touch
//
// At the tool pose of the frame the spring force equals the frame's force. The force jump caused by a new
// plane is blended out over time. On a rough surface the slip of the proxy is the path of the vibration
// (texture.hpp); a proxy that a new plane moves has not slipped.
#pragma once

#include "turgor/contact/lattice_touch.hpp"
#include "turgor/contact/needle_reading.hpp"
#include "turgor/contact/texture.hpp"
#include "turgor/contact/tool_io.hpp"
#include "turgor/contact/touch.hpp"
#include "turgor/models/cloth/cloth.hpp"

namespace turgor::contact {

/// Contact of a needle in a frame (lattice_needle.hpp). Its normal is that of the shaft: between two bounds a
/// spring holds the needle along it, and at a bound the needle slips or cuts.
struct LocalNeedle {
  bool is_needle = false;
  double lowest = 0, highest = 0;  // bounds of the force along the normal [N]
  bool is_touching = false;        // the tip is on the surface, which it punctures at `highest`
  double after_puncture = 0;       // the upper bound then [N]
  NeedleReading reading;           // of the frame, as the next members, for logs
  NeedleWork work;
  int punctures = 0;
  double entry_force = 0;  // [N]
};

/// Contact of one tool in a frame, in the world frame.
struct LocalContact {
  bool is_near = false;        // false: no tissue within reach of the tool
  bool is_held = false;        // the tool holds tissue, so the contact also pulls
  Vec3d origin;                // tool's origin at the end of the frame's step [m]
  Vec3d normal{0, 0, 1};       // unit, from the tissue toward the tool
  Vec3d force;                 // on the tool [N]
  Vec3d arm;                   // from the tool's origin to the point of action [m]
  double gap = 0;              // distance from the tool to the tissue; 0 in contact [m]
  double stiffness = 0;        // along the normal [N/m]
  double shear_stiffness = 0;  // tangential [N/m]
  double friction = 0;         // Coulomb's μ [1]
  double reach = 0;            // distance from `origin` within which the plane is valid [m]
  long number = 0;             // number of planes published for this tool
  int teleports = 0;           // number of the tool's teleports when the plane was computed
  Waves waves;                 // of the surface
  LocalNeedle needle;
};

struct LocalTouchParams {
  double blend_time = 0.03;    // time constant with which a force jump decays [s]
  double largest_step = 0.02;  // largest change of the force by blending per tick [N]
  double damping = 0.5;  // d in the damping factor 1 + d v, with v the tool's speed into the tissue [s/m]
};

/// State of one tool, owned by the haptic thread.
struct LocalTouch {
  LocalTouchParams params;
  std::shared_ptr<const HeightMap> map;  // of the surface; null = none
  LocalContact contact;
  Vec3d proxy;            // position of the tool's origin at which the shear force is zero [m]
  Vec3d remaining_jump;   // remaining force jump of the newest plane [N]
  double reference = 0;   // normal force of the plane when it was published; below this force the added jump
                          // is reduced in proportion [N]
  bool seen = false;      // true after the first tick; the next two members describe the last tick
  Vec3d position, force;  // the force without texture [m] [N]
  double largest_jump = 0;  // largest force jump of all planes, before blending [N]
  double slip = 0;          // of a needle along the normal since the newest plane [m]
  TextureState texture;
};

/// Ends the contact of a teleported tool.
void end_contact(LocalTouch& touch);
/// Replaces the plane by a newer one, between two ticks.
void update_contact(LocalTouch& touch, const LocalContact& contact);
/// Force of one tick of `dt` seconds. Does not allocate or wait.
void tick_local_touch(LocalTouch& touch, const ToolCommand& command, double dt, ToolReading& reading);

/// Previous frame of one tool. Stiffness is measured as change of the force per displacement of the tool.
struct LocalContactHistory {
  bool seen = false;
  Vec3d position;           // of the tool [m]
  double normal_force = 0;  // of the previous frame [N]
  double gap = 0;           // of the previous frame [m]
  double stiffness = 0;     // newest measurement; 0 = none yet [N/m]
};
/// Local contact after a lattice step (step_with_tools) that moved the tool to `pose` [patient frame].
LocalContact local_contact(const lattice::Model& model, const lattice::Motion& motion,
                           const LatticeTouch& touch, int tool_index, const Tool& tool, const ToolPose& pose,
                           LocalContactHistory& memory);
/// Local contact after a cloth step of `dt` seconds that moved the tool to `pose`. In that step the tool was
/// the obstacle with index `obstacle` and contact distance `gap` (cloth_obstacle.hpp).
LocalContact local_contact(const cloth::Model& model, const cloth::State& state, int obstacle, double gap,
                           const Tool& tool, const Pose& pose, double dt, LocalContactHistory& memory);

}  // namespace turgor::contact
