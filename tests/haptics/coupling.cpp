#include "turgor/haptics/coupling.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "turgor/haptics/rotation.hpp"
#include "turgor/haptics/safety.hpp"
#include "turgor/haptics/virtual_device.hpp"

namespace turgor::haptics {
namespace {

using contact::ToolReading;

constexpr double kTick = 1e-3;

contact::Pose at(Vec3d x) { return {.position = x, .axes = {}}; }

TEST(coupling, a_hand_that_rests_in_a_body_feels_both_springs_in_series) {
  for (const double stiffness : {200.0, 1000.0, 50000.0}) {
    const Coupling coupling;
    CoupledTool tool;
    ToolReading reading;
    follow(coupling, at({}), reading, kTick, tool);
    for (int i = 0; i < 5000; i++) {  // 4 mm into a wall at 0, slowly
      follow(coupling, at({0, 0, -0.004 * std::min(1.0, i / 1000.0)}), reading, kTick, tool);
      reading.force.z = stiffness * std::max(0.0, -tool.pose.position.z);
    }
    const double series = 1 / (1 / stiffness + 1 / coupling.stiffness);
    EXPECT_NEAR(haptic(tool, reading).force.z, 0.004 * series, 1e-6 * series);
    EXPECT_NEAR(reading.force.z, 0.004 * series, 1e-6 * series);  // the model's force is the same one
  }
}

TEST(coupling, in_free_space_a_steady_hand_feels_nothing_and_an_accelerated_one_the_tools_mass) {
  const Coupling coupling;
  CoupledTool tool;
  for (int i = 0; i < 3000; i++)
    follow(coupling, {.position = {1e-4 * i, 0, 0}, .axes = rotation({0, 0, 3e-4 * i})}, {}, kTick, tool);
  EXPECT_LT(norm(tool.force), 1e-6);
  EXPECT_LT(norm(tool.torque), 1e-9);
  EXPECT_NEAR(tool.velocity.x, 0.1, 1e-6);
  EXPECT_NEAR(tool.angular_velocity.z, 0.3, 1e-6);
  tool = {};
  for (int i = 0; i < 1000; i++) {
    const double t = kTick * i;
    follow(coupling, at({0.5 * 2 * t * t, 0, 0}), {}, kTick, tool);  // 2 m/s²
  }
  EXPECT_NEAR(tool.force.x, -2 * coupling.mass, 1e-3);
}

TEST(coupling, a_turned_hand_feels_the_torque_that_holds_the_tool) {
  const Coupling coupling;
  CoupledTool tool;
  ToolReading reading;
  follow(coupling, at({}), reading, kTick, tool);
  for (int i = 0; i < 5000; i++) {
    follow(coupling, {.position = {}, .axes = rotation({0, 0.2 * std::min(1.0, i / 1000.0), 0})}, reading,
           kTick, tool);
    reading.torque = rotation_vector(tool.pose.axes) * -3.0;
  }
  EXPECT_NEAR(haptic(tool, reading).torque.y, -0.2 * 3 * 1 / (3.0 + 1), 1e-5);
}

/// How far a hand that presses a wall still moves in the last half second [m].
double shaking(double wall, bool coupled) {
  VirtualDevice device({}, {.mass = 0.1, .damping = 1, .stiffness = 300, .target = [](double t) {
                              return HandTarget{.pose = at({0, 0, 0.005 - 0.01 * std::min(1.0, 4 * t)})};
                            }});
  (void)device.open();
  Safety safety = make_safety(device.spec(), {.force = 12, .ramp = 0.01, .passivity_control = false});
  const Coupling coupling;
  CoupledTool tool;
  ToolReading reading;
  SafeOutput output;
  Asked asked;
  double low = 1, high = -1;
  while (device.time() < 2.5) {
    device.exchange(output.value(), asked.hand);
    contact::Pose pose = asked.hand.pose;
    if (coupled) follow(coupling, pose, reading, kTick, tool), pose = tool.pose;
    reading.force.z = wall * std::max(0.0, -pose.position.z);
    asked.wanted.force = coupled ? haptic(tool, reading).force : reading.force;
    output = make_safe(safety, asked, kTick);
    const double z = device.pose().position.z;
    if (device.time() > 2) low = std::min(low, z), high = std::max(high, z);
  }
  return high - low;
}

TEST(coupling, bone_that_would_shake_the_hand_is_felt_at_rest) {
  for (const double wall : {15000.0, 60000.0}) {
    EXPECT_GT(shaking(wall, false), 1e-3) << wall;
    EXPECT_LT(shaking(wall, true), 5e-5) << wall;
  }
}

TEST(coupling, numbers_that_are_not_finite_move_no_tool_and_are_handed_on_for_safety_to_see) {
  const Coupling coupling;
  CoupledTool tool;
  ToolReading reading;
  reading.force.x = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 10; i++) follow(coupling, at({1e-3, 0, 0}), reading, kTick, tool);
  EXPECT_EQ(tool.pose.position, (Vec3d{1e-3, 0, 0}));
  EXPECT_TRUE(std::isnan(haptic(tool, reading).force.x));
}

}  // namespace
}  // namespace turgor::haptics
