#include "turgor/haptics/loop.hpp"

#include <atomic>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>

#include "tests/haptics/still_device.hpp"
#include "tests/haptics/wall_loop.hpp"
#include "turgor/haptics/virtual_device.hpp"

namespace turgor::haptics {
namespace {

using contact::ToolCommand;
using contact::ToolReading;

/// True if the hand is at rest at `hand` with the given force, and the tool is at `tool`.
bool is_at_rest(Loop& loop, double hand, double tool, double force) {
  const HandStatus& status = loop.status(0);
  return std::abs(status.input.velocity.z) < 1e-3 && std::abs(status.input.pose.position.z - hand) < 2e-4 &&
         std::abs(status.command.pose.position.z - tool) < 2e-4 &&
         std::abs(status.output.force.z - force) < 0.1;
}

// A hand that presses a wall stops moving where the forces of hand and wall balance.
TEST(Loop, HandRestsAtForceBalance) {
  VirtualDevice device({}, light_grip(press), VirtualTime::kClock);
  ASSERT_TRUE(device.open());
  Wall wall;
  auto loop = Loop::start({{.device = &device, .safety = short_ramp()}}, Wall::tick, &wall, kPlain);
  ASSERT_TRUE(loop);
  const double z = -0.005 * 300 / 800;  // 300 (−5 mm − z) = 500 z
  EXPECT_TRUE(wait_for([&] { return is_at_rest(**loop, z, z, -500 * z); }));
  EXPECT_TRUE((*loop)->running());
  (*loop)->stop();
  EXPECT_FALSE((*loop)->running());
  EXPECT_GT((*loop)->report().ticks, 10u);
}

// With coupling the hand rests against wall and coupling in series.
TEST(Loop, CoupledForceIsSpringsInSeries) {
  VirtualDevice device({}, light_grip(press), VirtualTime::kClock);
  ASSERT_TRUE(device.open());
  Wall wall;
  auto loop = Loop::start({{.device = &device, .coupling = Coupling{}, .safety = short_ramp()}}, Wall::tick,
                          &wall, kPlain);
  ASSERT_TRUE(loop);
  const double series = 500.0 * 1000 / 1500, z = -0.005 * 300 / (300 + series);
  EXPECT_TRUE(wait_for([&] { return is_at_rest(**loop, z, z * series / 500, -series * z); }));
}

// Two hands share each tick, and each has its own workspace.
TEST(Loop, TwoHandsShareTicks) {
  StillDevice left, right;
  left.z = -0.002, right.z = 0.001;
  Wall wall;
  Workspace lower{.origin = {0, 0, -0.004}};
  auto loop = Loop::start({{.device = &left, .safety = short_ramp()},
                           {.device = &right, .workspace = lower, .safety = short_ramp()}},
                          Wall::tick, &wall, kPlain);
  ASSERT_TRUE(loop);
  // Both start inside the wall: no force until they have left it.
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(left.largest, 0);
  left.z = 0.01, right.z = 0.01;
  ASSERT_TRUE(wait_for([&] {
    return (*loop)->status(0).start == SoftStart::kFull && (*loop)->status(1).start == SoftStart::kFull;
  }));
  left.z = -0.002, right.z = 0.001;
  EXPECT_TRUE(wait_for([&] { return std::abs(left.last - 1) < 1e-9 && std::abs(right.last - 1.5) < 1e-9; }));
  EXPECT_EQ(wall.tools, 2u);
}

// Stopping fades the force, ends the thread and closes the devices.
TEST(Loop, StopFadesForceAndCloses) {
  StillDevice device;
  Wall wall;
  auto loop = Loop::start({{.device = &device, .safety = short_ramp()}}, Wall::tick, &wall, kPlain);
  ASSERT_TRUE(loop);
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).start == SoftStart::kFull; }));
  device.z = -0.02;
  ASSERT_TRUE(wait_for([&] { return device.last > 9.9; }));
  (*loop)->stop();
  EXPECT_EQ(device.last, 0);
  EXPECT_TRUE(device.closed);
  const int ticks = wall.ticks;
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(wall.ticks, ticks);
  EXPECT_LE((*loop)->report().force_jump,
            12 * 2 * 1e-3 / 0.005 * 1.0001);  // no step exceeds the slew rate
  (*loop)->stop();
}

// A model that throws stops the forces but not the program.
TEST(Loop, ThrowingModelStopsForces) {
  StillDevice device;
  struct Thrower {
    std::atomic<int> ticks = 0;
    static void tick(void* context, std::span<const ToolCommand>, double, std::span<ToolReading> readings) {
      readings[0].force.z = 1;
      if (++static_cast<Thrower*>(context)->ticks > 50) throw std::runtime_error("no convergence");
    }
  } model;
  auto loop = Loop::start({{.device = &device, .safety = {.small_force = 2, .ramp = 0.005}}}, Thrower::tick,
                          &model, kPlain);
  ASSERT_TRUE(loop);
  EXPECT_TRUE(wait_for([&] { return !(*loop)->running(); }));
  EXPECT_TRUE(wait_for([&] { return device.last == 0; }));
  EXPECT_EQ((*loop)->notes().size(), 1u);
  EXPECT_EQ(device.largest, 1);
}

// The pressed clutch detaches the tool from the hand and sends zero force.
TEST(Loop, ClutchDetachesToolAndForce) {
  StillDevice device;
  Wall wall;
  auto loop = Loop::start({{.device = &device, .safety = short_ramp()}}, Wall::tick, &wall, kPlain);
  ASSERT_TRUE(loop);
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).start == SoftStart::kFull; }));
  device.z = -0.002;
  ASSERT_TRUE(wait_for([&] { return device.last > 0.9; }));
  device.buttons = Buttons{}.clutch;
  ASSERT_TRUE(wait_for([&] { return device.last == 0; }));
  device.z = 0.03;
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).input.pose.position.z == 0.03; }));
  EXPECT_NEAR((*loop)->status(0).command.pose.position.z, -0.002, 1e-12);
}

// A loop without devices, or with a rate of zero, is an error.
TEST(Loop, InvalidParametersAreErrors) {
  Wall wall;
  const auto none = Loop::start({}, Wall::tick, &wall);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("expected a device"), std::string::npos);
  StillDevice device;
  const auto slow = Loop::start({{.device = &device}}, Wall::tick, &wall, {.rate = 0});
  ASSERT_FALSE(slow);
  EXPECT_NE(slow.error().message.find("found 0"), std::string::npos);
}

// A real-time priority that the system denies gives a note and no error.
TEST(Loop, MissingPrivilegesAreNotes) {
  StillDevice device;
  Wall wall;
  auto loop = Loop::start({{.device = &device}}, Wall::tick, &wall,
                          {.rate = 1000, .priority = 80, .lock_memory = false});
  ASSERT_TRUE(loop);
  EXPECT_TRUE(wait_for([&] { return wall.ticks > 10; }));
  for (const std::string& note : (*loop)->notes()) EXPECT_NE(note.find("ulimit"), std::string::npos) << note;
}

}  // namespace
}  // namespace turgor::haptics
