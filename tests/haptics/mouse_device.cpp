#include "turgor/haptics/mouse_device.hpp"

#include <gtest/gtest.h>

#include "turgor/haptics/real_time.hpp"

namespace turgor::haptics {
namespace {

constexpr Box kReach{{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}};

/// Exchanges a thousand times per second, like the haptic loop.
DeviceInput exchange_for(MouseDevice& device, double seconds, const DeviceOutput& output = {}) {
  DeviceInput input;
  const double begin = steady_seconds();
  for (int tick = 1; steady_seconds() < begin + seconds; tick++) {
    EXPECT_TRUE(device.exchange(output, input));
    sleep_until(begin + tick * 1e-3);
  }
  return input;
}

MouseHand at(Vec3d position, int teleports, bool hold = false) {
  return {.pose = {position, {}}, .hold = hold, .teleports = teleports, .teleport_to = position};
}

// The device counts as driven only after the first exchange with a target.
TEST(MouseDevice, DrivenFromFirstTargetExchange) {
  MouseDevice device(kReach);
  ASSERT_TRUE(device.open());
  DeviceInput input;
  ASSERT_TRUE(device.exchange({}, input));
  EXPECT_FALSE(device.is_driven());
  device.set_target(at({0.3, 0, 0}, 1));
  EXPECT_FALSE(device.is_driven()) << "a tick in progress still uses the old position";
  ASSERT_TRUE(device.exchange({}, input));
  EXPECT_TRUE(device.is_driven());
  EXPECT_LT(norm(input.pose.position - Vec3d{0.3, 0, 0}), 1e-6);
}

// A teleport takes effect at once; later targets are reached within a quarter of a second.
TEST(MouseDevice, TeleportsThenFollows) {
  MouseDevice device(kReach);
  ASSERT_TRUE(device.open());
  device.set_target(at({0.1, 0.2, -0.05}, 1));
  DeviceInput input;
  ASSERT_TRUE(device.exchange({}, input));
  EXPECT_LT(norm(input.pose.position - Vec3d{0.1, 0.2, -0.05}), 1e-6);
  device.set_target(at({0.12, 0.2, -0.05}, 1, true));
  ASSERT_TRUE(device.exchange({}, input));
  EXPECT_LT(norm(input.pose.position - Vec3d{0.1, 0.2, -0.05}), 0.005) << "follows, does not teleport";
  input = exchange_for(device, 0.25);
  EXPECT_LT(norm(input.pose.position - Vec3d{0.12, 0.2, -0.05}), 2e-4);
  EXPECT_EQ(input.buttons, Buttons().hold);
}

// A force displaces the tool by force over spring stiffness.
TEST(MouseDevice, ForceDisplacesToolBySpring) {
  MouseDevice device(kReach);
  ASSERT_TRUE(device.open());
  device.set_target(at({}, 1));
  const DeviceInput input =
      exchange_for(device, 0.5, {.force = {0, 2.4, -1.2}, .torque = {}, .grip_force = 0});
  EXPECT_NEAR(input.pose.position.y, 2.4 / MouseDevice::kStiffness, 2e-5);
  EXPECT_NEAR(input.pose.position.z, -1.2 / MouseDevice::kStiffness, 2e-5);
}

}  // namespace
}  // namespace turgor::haptics
