// Devices that a haptic loop loses: unplugged, silent, returned.
#include <chrono>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/haptics/still_device.hpp"
#include "tests/haptics/wall_loop.hpp"
#include "turgor/haptics/loop.hpp"

namespace turgor::haptics {
namespace {

// A lost device gets zero force and is reported; the other hand continues.
TEST(LostDevices, LostDeviceLeavesOtherRunning) {
  StillDevice lost, other;
  Wall wall;
  auto loop =
      Loop::start({{.device = &lost, .safety = short_ramp()}, {.device = &other, .safety = short_ramp()}},
                  Wall::tick, &wall, kPlain);
  ASSERT_TRUE(loop);
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).start == SoftStart::kFull; }));
  lost.z = other.z = -0.002;
  ASSERT_TRUE(wait_for([&] { return lost.last > 0.9; }));
  lost.unplugged = true;
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).lost; }));
  lost.largest = 0;
  const int ticks = wall.ticks;
  ASSERT_TRUE(wait_for([&] { return wall.ticks > ticks + 20; }));
  EXPECT_EQ(lost.largest, 0);
  EXPECT_GT(other.last, 0.9);
  EXPECT_TRUE((*loop)->running());
  const std::vector<std::string> notes = (*loop)->notes();
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("still was lost: its cable is out"), std::string::npos) << notes[0];
  other.unplugged = true;  // now all devices are lost, and the model goes on
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(1).lost; }));
  const int alone = wall.ticks;
  EXPECT_TRUE(wait_for([&] { return wall.ticks > alone + 20; }));
  EXPECT_TRUE((*loop)->running());
}

/// The device answers again, and its force is off.
bool is_waiting(Loop& loop) {
  const HandStatus& status = loop.status(0);
  return !status.lost && status.start == SoftStart::kWaiting;
}

// A device that is plugged in again while its hand is deep inside a body gets no force until the hand has
// left it, then a soft start.
TEST(LostDevices, ReturnedDeviceStartsSoftly) {
  StillDevice device;
  Wall wall;
  SafetyParams safety = short_ramp();
  safety.ramp = 0.2;
  auto loop =
      Loop::start({{.device = &device, .coupling = Coupling{}, .safety = safety}}, Wall::tick, &wall, kPlain);
  ASSERT_TRUE(loop);
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).start == SoftStart::kFull; }));
  device.z = -0.002;
  ASSERT_TRUE(wait_for([&] { return device.last > 0.6; }));
  // without an answer for 200 ms; the hand moves meanwhile, by less than a jump
  device.unplugged = true;
  device.z = -0.02;
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).lost; }));
  EXPECT_EQ((*loop)->news().size(), 1u);  // its reason is known only while it is lost
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  device.largest = 0;
  device.unplugged = false;
  ASSERT_TRUE(wait_for([&] { return is_waiting(**loop); }));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_EQ(device.largest, 0) << "N, inside the wall";
  EXPECT_NEAR((*loop)->status(0).command.pose.position.z, -0.02 * 1000 / 1500, 1e-4)
      << "m: the proxy rests between coupling and wall";
  // outside, then a press
  device.z = 0.01;
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).start == SoftStart::kFull; }));
  device.z = -0.002;
  const double series = 500.0 * 1000 / 1500;
  EXPECT_TRUE(wait_for([&] { return std::abs(device.last - 0.002 * series) < 1e-6; })) << device.last;
  (*loop)->stop();
  EXPECT_LE((*loop)->report().force_jump, 12 * 2 * 1e-3 / 0.005 * 1.0001);
  const std::vector<std::string> notes = (*loop)->notes();
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("still was lost: its cable is out; it returned"), std::string::npos) << notes[0];
}

// The tool of a device that has not answered yet is in the middle of its workspace.
TEST(LostDevices, SilentDeviceLeavesToolInMiddle) {
  StillDevice device;
  device.unplugged = true;
  Wall wall;
  const Workspace workspace{.origin = {0.1, 0.2, 0.3}};
  auto loop = Loop::start({{.device = &device, .workspace = workspace}}, Wall::tick, &wall, kPlain);
  ASSERT_TRUE(loop);
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).lost; }));
  EXPECT_EQ((*loop)->status(0).command.pose.position, workspace.origin);
}

// The reason of a loss is known after stop, which closes the device.
TEST(LostDevices, LossIsReportedAfterStop) {
  StillDevice device;
  Wall wall;
  auto loop = Loop::start({{.device = &device}}, Wall::tick, &wall, kPlain);
  ASSERT_TRUE(loop);
  device.unplugged = true;
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).lost; }));
  (*loop)->stop();
  device.unplugged = false;  // a closed device states another reason
  const std::vector<std::string> notes = (*loop)->notes();
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("still was lost: its cable is out"), std::string::npos) << notes[0];
}

// Ticks go on after a device that called them has ended its calls, and its loss is reported.
TEST(LostDevices, EndedCallsAreALoss) {
  for (const int pause : {130, 400}) {  // until stop: before and after the ticks notice [ms]
    StillDevice device(Pacing::kCallback);
    Wall wall;
    auto loop = Loop::start({{.device = &device, .safety = short_ramp()}}, Wall::tick, &wall, kPlain);
    ASSERT_TRUE(loop);
    ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).start == SoftStart::kFull; }));
    device.unplugged = true;
    device.close();
    const int ticks = wall.ticks;
    std::this_thread::sleep_for(std::chrono::milliseconds(pause));
    if (pause > 200) {
      EXPECT_TRUE(wait_for([&] { return wall.ticks > ticks + 50; }));
    }
    (*loop)->stop();
    const std::vector<std::string> notes = (*loop)->notes(), news = (*loop)->news();
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_NE(notes[0].find("still was lost: its cable is out; its forces are off"), std::string::npos)
        << notes[0];
    EXPECT_EQ(news.size(), 1u);
  }
}

}  // namespace
}  // namespace turgor::haptics
