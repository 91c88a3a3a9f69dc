#include "turgor/haptics/mouse_device.hpp"

#include <gtest/gtest.h>

#include "turgor/haptics/real_time.hpp"

namespace turgor::haptics {
namespace {

constexpr Box kReach{{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}};

/// Exchanges a thousand times a second, as the loop does.
DeviceInput exchange_for(MouseDevice& device, double seconds, const DeviceOutput& output = {}) {
  DeviceInput input;
  const double begin = steady_seconds();
  for (int tick = 1; steady_seconds() < begin + seconds; tick++) {
    EXPECT_TRUE(device.exchange(output, input));
    sleep_until(begin + tick * 1e-3);
  }
  return input;
}

MouseHand at(Vec3d place, int put, bool hold = false) {
  return {.pose = {place, {}}, .hold = hold, .put = put, .put_at = place};
}

TEST(mouse_device, it_is_led_from_the_exchange_on_that_says_where_the_mouse_is) {
  MouseDevice device(kReach);
  ASSERT_TRUE(device.open());
  DeviceInput input;
  ASSERT_TRUE(device.exchange({}, input));
  EXPECT_FALSE(device.is_led());
  device.lead(at({0.3, 0, 0}, 1));
  EXPECT_FALSE(device.is_led()) << "a tick that is on its way still has the place of before";
  ASSERT_TRUE(device.exchange({}, input));
  EXPECT_TRUE(device.is_led());
  EXPECT_LT(norm(input.pose.position - Vec3d{0.3, 0, 0}), 1e-6);
}

TEST(mouse_device, it_is_put_at_once_and_led_from_there_within_a_quarter_of_a_second) {
  MouseDevice device(kReach);
  ASSERT_TRUE(device.open());
  device.lead(at({0.1, 0.2, -0.05}, 1));
  DeviceInput input;
  ASSERT_TRUE(device.exchange({}, input));
  EXPECT_LT(norm(input.pose.position - Vec3d{0.1, 0.2, -0.05}), 1e-6);
  device.lead(at({0.12, 0.2, -0.05}, 1, true));
  ASSERT_TRUE(device.exchange({}, input));
  EXPECT_LT(norm(input.pose.position - Vec3d{0.1, 0.2, -0.05}), 0.005) << "led, not put";
  input = exchange_for(device, 0.25);
  EXPECT_LT(norm(input.pose.position - Vec3d{0.12, 0.2, -0.05}), 2e-4);
  EXPECT_EQ(input.buttons, Buttons().hold);
}

TEST(mouse_device, a_force_holds_the_tool_back_by_force_over_the_stiffness_of_the_spring) {
  MouseDevice device(kReach);
  ASSERT_TRUE(device.open());
  device.lead(at({}, 1));
  const DeviceInput input =
      exchange_for(device, 0.5, {.force = {0, 2.4, -1.2}, .torque = {}, .grip_force = 0});
  EXPECT_NEAR(input.pose.position.y, 2.4 / MouseDevice::kStiffness, 2e-5);
  EXPECT_NEAR(input.pose.position.z, -1.2 / MouseDevice::kStiffness, 2e-5);
}

}  // namespace
}  // namespace turgor::haptics
