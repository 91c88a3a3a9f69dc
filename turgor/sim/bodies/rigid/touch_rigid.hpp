// Tools on a rigid body. A tool is a body of the coupling (sim/organs/coupling.hpp) whose motion in the next
// frame is given. Its contact sites and the springs of a grasp are solved together with all others, so that
// the force on the body is exactly the reverse of that on the tool. A rigid body does not yield: the
// stiffness of a touched point is a key of the scene.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "turgor/contact/coupling.hpp"
#include "turgor/contact/pair_sites.hpp"
#include "turgor/contact/touch.hpp"
#include "turgor/sim/tools/touched_body.hpp"

namespace turgor {

struct RigidBody;
struct World;

/// Contact of one tool.
struct RigidTouch {
  contact::Tool tool;
  TriMesh mesh;                          // about the tool's origin
  double radius = 0;                     // of its tip [m]
  Pose pose;                             // at the end of the latest frame
  Pose next;                             // at the end of the next frame
  bool hold = false;                     // command of the next frame
  std::optional<Pose> grasped;           // pose of the held body in the tool's frame; empty = it holds none
  std::vector<contact::PairSite> sites;  // of the next frame, from the latest solution on
  std::vector<contact::Tie> grasp;       // springs between the tool and the held body
  contact::RigidLoad load;               // on the tool in the next frame [N] [N·m]
  contact::ToolForce force;              // on the tool in the latest frame
};

/// Surface of a rigid body at the present positions of its vertices.
contact::PairSurface rigid_surface(const RigidBody& body, int index, std::span<const Vec3d> x);

/// Motion of a tool in the next frame as the coupling sees it. While it holds the body, points of the tool
/// have the rest positions of the body.
contact::RigidMotion tool_motion(const RigidTouch& touch);

/// Sets the poses of the next frame, which ends at a time, and finds sites and grasps. `index`: number of the
/// body in the coupling; `first_tool`: number of the first tool of the world.
void find_tool_sites(const Exec& exec, const World& world, RigidBody& body, int index, int first_tool,
                     const contact::PairSurface& surface, double end);
/// Stores the forces on the tools that the coupling found for the next frame.
void read_tool_loads(RigidBody& body, int first_tool);

/// The next frame became the latest one: logs the tools, and publishes their contact planes for ticks.
void record_touch(const Exec& exec, RigidBody& body, World& world, double time);

}  // namespace turgor
