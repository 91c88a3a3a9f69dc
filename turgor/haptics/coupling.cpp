#include "turgor/haptics/coupling.hpp"

#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/haptics/rotation.hpp"

namespace turgor::haptics {

namespace {

bool is_finite(const contact::ToolReading& reading) {
  return std::isfinite(dot(reading.force, reading.force)) &&
         std::isfinite(dot(reading.torque, reading.torque));
}

/// Spring and damper of translation or rotation.
struct Spring {
  double stiffness, damping, mass;
};

/// Backward Euler step of the proxy's speed under `push`. At the end of the tick the hand has `offset` from
/// the proxy's old pose and the velocity `hand_speed`. Returns the proxy's displacement. `force` is the
/// coupling's force on the hand.
Vec3d advance_spring(const Spring& s, Vec3d push, Vec3d offset, Vec3d hand_speed, double dt, Vec3d& speed,
                     Vec3d& force) {
  TURGOR_CHECK(s.mass + dt * s.damping + dt * dt * s.stiffness > 0,
               "a coupling has mass, damping or stiffness");
  const Vec3d pulled = push + offset * s.stiffness + hand_speed * s.damping;
  speed = (speed * s.mass + pulled * dt) / (s.mass + dt * s.damping + dt * dt * s.stiffness);
  const Vec3d displacement = speed * dt;
  force = (displacement - offset) * s.stiffness + (speed - hand_speed) * s.damping;
  return displacement;
}

}  // namespace

void advance_coupled_tool(const Coupling& c, const contact::Pose& hand, const contact::ToolReading& reading,
                          double dt, CoupledTool& tool) {
  if (!tool.is_initialized) tool = {.pose = hand, .hand = hand, .is_initialized = true};
  if (!(dt > 0)) return;
  const contact::ToolReading pushed = is_finite(reading) ? reading : contact::ToolReading{};
  tool.pose.position +=
      advance_spring({c.stiffness, c.damping, c.mass}, pushed.force, hand.position - tool.pose.position,
                     (hand.position - tool.hand.position) / dt, dt, tool.velocity, tool.force);
  const Vec3d turn = advance_spring({c.angular_stiffness, c.angular_damping, c.inertia}, pushed.torque,
                                    rotation_vector(hand.axes * transposed(tool.pose.axes)),
                                    rotation_vector(hand.axes * transposed(tool.hand.axes)) / dt, dt,
                                    tool.angular_velocity, tool.torque);
  tool.pose.axes = rotation(turn) * tool.pose.axes;
  tool.hand = hand;
}

contact::ToolReading coupled_reading(const CoupledTool& tool, const contact::ToolReading& reading) {
  contact::ToolReading out = reading;
  if (is_finite(reading)) out.force = tool.force, out.torque = tool.torque;
  return out;
}

}  // namespace turgor::haptics
