#include "turgor/haptics/mouse_device.hpp"

#include <cmath>

namespace turgor::haptics {

namespace {

/// Exact and without dry friction: no hand of flesh holds it.
VirtualArm mouse_arm(const Box& reach) {
  VirtualArm arm;
  arm.mass = 0.05;
  arm.coulomb = arm.angular_coulomb = arm.encoder = arm.angular_encoder = 0;
  arm.workspace_low = reach.low, arm.workspace_high = reach.high;
  return arm;
}

/// Critically damped, or nearly so.
VirtualHand mouse_hand(std::function<HandTarget(double)> target) {
  VirtualHand hand = light_hand(std::move(target));
  hand.mass = 0.05, hand.damping = 14, hand.stiffness = MouseDevice::kStiffness;
  return hand;
}

}  // namespace

MouseDevice::MouseDevice(const Box& reach)
    : arm_(mouse_arm(reach), mouse_hand([this](double) { return goal_; }), VirtualTime::kClock),
      spec_(arm_.spec()) {
  spec_.name = "mouse";
}

void MouseDevice::lead(const MouseHand& hand) { said_.write(hand); }

bool MouseDevice::exchange(const DeviceOutput& output, DeviceInput& input) noexcept {
  constexpr double kShare = 0.06;  // of the way, a tick: a jump of the mouse takes some 20 ms
  is_led_ = is_led_ || said_.has_news();
  const MouseHand& said = said_.read();
  const bool is_put = said.put != put_;
  Vec3d& goal = goal_.pose.position;
  if (is_put) goal = said.put_at, put_ = said.put;
  goal_.pose.axes = said.pose.axes;
  goal_.buttons = said.hold ? Buttons().hold : 0u;
  if (is_put) arm_.put(goal_.pose);
  goal += (said.pose.position - goal) * kShare;
  return arm_.exchange(output, input);
}

}  // namespace turgor::haptics
