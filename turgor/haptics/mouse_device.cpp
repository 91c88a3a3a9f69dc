#include "turgor/haptics/mouse_device.hpp"

#include <cmath>

#include "turgor/core/assert.hpp"

namespace turgor::haptics {

namespace {

/// Arm with an exact encoder and no dry friction, because it has no real hand.
VirtualArm mouse_arm(const Box& reach) {
  VirtualArm arm;
  arm.mass = 0.05;
  arm.coulomb = arm.angular_coulomb = arm.encoder = arm.angular_encoder = 0;
  TURGOR_CHECK(reach.low.x <= reach.high.x && reach.low.y <= reach.high.y && reach.low.z <= reach.high.z,
               "the range of a tool has its lower corner first");
  arm.workspace_low = reach.low, arm.workspace_high = reach.high;
  return arm;
}

/// Nearly critically damped hand.
VirtualHand mouse_hand(std::function<HandTarget(double)> target) {
  VirtualHand hand = light_grip(std::move(target));
  hand.mass = 0.05, hand.damping = 14, hand.stiffness = MouseDevice::kStiffness;
  return hand;
}

}  // namespace

MouseDevice::MouseDevice(const Box& reach)
    : arm_(mouse_arm(reach), mouse_hand([this](double) { return goal_; }), VirtualTime::kClock),
      spec_(arm_.spec()) {
  spec_.name = "mouse";
}

void MouseDevice::set_target(const MouseHand& hand) { target_.write(hand); }

bool MouseDevice::exchange(const DeviceOutput& output, DeviceInput& input) noexcept {
  constexpr double kStepFraction = 0.06;  // of the distance, a tick: a jump of the mouse takes some 20 ms
  is_driven_ = is_driven_ || target_.has_news();
  const MouseHand& mouse = target_.read();
  // teleport the spring's target and the arm
  const bool is_teleported = mouse.teleports != teleports_;
  Vec3d& goal = goal_.pose.position;
  if (is_teleported) goal = mouse.teleport_to, teleports_ = mouse.teleports;
  goal_.pose.axes = mouse.pose.axes;
  goal_.buttons = mouse.hold ? Buttons().hold : 0u;
  // the spring's target follows the mouse smoothly
  if (is_teleported) arm_.teleport(goal_.pose);
  goal += (mouse.pose.position - goal) * kStepFraction;
  return arm_.exchange(output, input);
}

}  // namespace turgor::haptics
