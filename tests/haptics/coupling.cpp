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

// At rest the haptic force is that of the coupling spring and the contact spring in series.
TEST(Coupling, ContactForceIsSpringsInSeries) {
  for (const double stiffness : {200.0, 1000.0, 50000.0}) {
    const Coupling coupling;
    CoupledTool tool;
    ToolReading reading;
    advance_coupled_tool(coupling, at({}), reading, kTick, tool);
    for (int i = 0; i < 5000; i++) {  // 4 mm into a wall at 0, slowly
      advance_coupled_tool(coupling, at({0, 0, -0.004 * std::min(1.0, i / 1000.0)}), reading, kTick, tool);
      reading.force.z = stiffness * std::max(0.0, -tool.pose.position.z);
    }
    const double series = 1 / (1 / stiffness + 1 / coupling.stiffness);
    EXPECT_NEAR(coupled_reading(tool, reading).force.z, 0.004 * series, 1e-6 * series);
    EXPECT_NEAR(reading.force.z, 0.004 * series, 1e-6 * series);  // the force of the model is the same
  }
}

// In free space a steady hand receives no force; an accelerated one receives the inertia of the tool.
TEST(Coupling, FreeSpaceForceIsToolInertia) {
  const Coupling coupling;
  CoupledTool tool;
  for (int i = 0; i < 3000; i++)
    advance_coupled_tool(coupling, {.position = {1e-4 * i, 0, 0}, .axes = rotation({0, 0, 3e-4 * i})}, {},
                         kTick, tool);
  EXPECT_LT(norm(tool.force), 1e-6);
  EXPECT_LT(norm(tool.torque), 1e-9);
  EXPECT_NEAR(tool.velocity.x, 0.1, 1e-6);
  EXPECT_NEAR(tool.angular_velocity.z, 0.3, 1e-6);
  tool = {};
  for (int i = 0; i < 1000; i++) {
    const double t = kTick * i;
    advance_coupled_tool(coupling, at({0.5 * 2 * t * t, 0, 0}), {}, kTick, tool);  // 2 m/s²
  }
  EXPECT_NEAR(tool.force.x, -2 * coupling.mass, 1e-3);
}

// At rest the haptic torque is that of the coupling spring and the contact spring in series.
TEST(Coupling, TorqueIsSpringsInSeries) {
  const Coupling coupling;
  CoupledTool tool;
  ToolReading reading;
  advance_coupled_tool(coupling, at({}), reading, kTick, tool);
  for (int i = 0; i < 5000; i++) {
    advance_coupled_tool(coupling,
                         {.position = {}, .axes = rotation({0, 0.2 * std::min(1.0, i / 1000.0), 0})}, reading,
                         kTick, tool);
    reading.torque = rotation_vector(tool.pose.axes) * -3.0;
  }
  EXPECT_NEAR(coupled_reading(tool, reading).torque.y, -0.2 * 3 * 1 / (3.0 + 1), 1e-5);
}

/// Peak-to-peak motion of a hand that presses a wall, in the last half second [m].
double oscillation(double wall, bool coupled) {
  VirtualDevice device({}, {.mass = 0.1, .damping = 1, .stiffness = 300, .target = [](double t) {
                              return HandTarget{.pose = at({0, 0, 0.005 - 0.01 * std::min(1.0, 4 * t)})};
                            }});
  (void)device.open();
  Safety safety = make_safety(device.spec(), {.force = 12, .ramp = 0.01, .passivity_control = false});
  const Coupling coupling;
  CoupledTool tool;
  ToolReading reading;
  SafeOutput output;
  SafetyInput input;
  double low = 1, high = -1;
  while (device.time() < 2.5) {
    device.exchange(output.value(), input.hand);
    contact::Pose pose = input.hand.pose;
    if (coupled) advance_coupled_tool(coupling, pose, reading, kTick, tool), pose = tool.pose;
    reading.force.z = wall * std::max(0.0, -pose.position.z);
    input.wanted.force = coupled ? coupled_reading(tool, reading).force : reading.force;
    output = make_safe(safety, input, kTick);
    const double z = device.pose().position.z;
    if (device.time() > 2) low = std::min(low, z), high = std::max(high, z);
  }
  return high - low;
}

// A wall as stiff as bone oscillates without the coupling and is at rest with it.
TEST(Coupling, StabilizesStiffWall) {
  for (const double wall : {15000.0, 60000.0}) {
    EXPECT_GT(oscillation(wall, false), 1e-3) << wall;
    EXPECT_LT(oscillation(wall, true), 5e-5) << wall;
  }
}

// A force that is not finite does not move the tool and is passed to the safety stage.
TEST(Coupling, NonFiniteForceReachesSafety) {
  const Coupling coupling;
  CoupledTool tool;
  ToolReading reading;
  reading.force.x = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 10; i++) advance_coupled_tool(coupling, at({1e-3, 0, 0}), reading, kTick, tool);
  EXPECT_EQ(tool.pose.position, (Vec3d{1e-3, 0, 0}));
  EXPECT_TRUE(std::isnan(coupled_reading(tool, reading).force.x));
}

}  // namespace
}  // namespace turgor::haptics
