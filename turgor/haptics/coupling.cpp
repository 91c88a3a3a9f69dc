#include "turgor/haptics/coupling.hpp"

#include <cmath>

#include "turgor/haptics/rotation.hpp"

namespace turgor::haptics {

namespace {

bool is_finite(const contact::ToolReading& reading) {
  return std::isfinite(dot(reading.force, reading.force)) &&
         std::isfinite(dot(reading.torque, reading.torque));
}

/// Of translation or of rotation.
struct Spring {
  double stiffness, damping, mass;
};

/// A backward Euler step of the tool's speed under `push`, the hand being `away` from it at the end of the
/// tick and moving with `hand_speed`. Returns how far the tool moves; `force` is the coupling's on the hand.
Vec3d step(const Spring& s, Vec3d push, Vec3d away, Vec3d hand_speed, double dt, Vec3d& speed, Vec3d& force) {
  const Vec3d pulled = push + away * s.stiffness + hand_speed * s.damping;
  speed = (speed * s.mass + pulled * dt) / (s.mass + dt * s.damping + dt * dt * s.stiffness);
  const Vec3d way = speed * dt;
  force = (way - away) * s.stiffness + (speed - hand_speed) * s.damping;
  return way;
}

}  // namespace

void follow(const Coupling& c, const contact::Pose& hand, const contact::ToolReading& reading, double dt,
            CoupledTool& tool) {
  if (!tool.began) tool = {.pose = hand, .hand = hand, .began = true};
  if (!(dt > 0)) return;
  const contact::ToolReading pushed = is_finite(reading) ? reading : contact::ToolReading{};
  tool.pose.position +=
      step({c.stiffness, c.damping, c.mass}, pushed.force, hand.position - tool.pose.position,
           (hand.position - tool.hand.position) / dt, dt, tool.velocity, tool.force);
  const Vec3d turn = step({c.angular_stiffness, c.angular_damping, c.inertia}, pushed.torque,
                          rotation_vector(hand.axes * transposed(tool.pose.axes)),
                          rotation_vector(hand.axes * transposed(tool.hand.axes)) / dt, dt,
                          tool.angular_velocity, tool.torque);
  tool.pose.axes = rotation(turn) * tool.pose.axes;
  tool.hand = hand;
}

contact::ToolReading haptic(const CoupledTool& tool, const contact::ToolReading& reading) {
  contact::ToolReading out = reading;
  if (is_finite(reading)) out.force = tool.force, out.torque = tool.torque;
  return out;
}

}  // namespace turgor::haptics
