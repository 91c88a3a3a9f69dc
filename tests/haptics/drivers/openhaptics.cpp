#include "turgor/haptics/drivers/openhaptics.hpp"

#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <mutex>
#include <thread>

#include "tests/allocations.hpp"
#include "tests/haptics/drivers/fake_library.hpp"
#include "tests/haptics/fakes/fake_hd.hpp"
#include "tests/refused.hpp"
#include "turgor/haptics/loop.hpp"

namespace turgor::haptics {
namespace {

/// Last input of the haptic thread, and the output that it sends.
struct HapticThread {
  std::mutex mutex;
  DeviceOutput output;
  DeviceInput input;
  int ticks = 0;
  std::size_t allocations = 0;
};

void haptic_tick(void* context, const DeviceInput& input, DeviceOutput& output) {
  HapticThread& haptic = *static_cast<HapticThread*>(context);
  const std::lock_guard lock(haptic.mutex);
  if (haptic.ticks == 0) haptic.allocations = test::allocations;
  haptic.input = input;
  output = haptic.output;
  haptic.ticks++;
}

class HdArm : public testing::Test {
 protected:
  HdArm() { arm.reset(); }
  ~HdArm() override {
    if (device) device->close();
  }

  Status open(DeviceOptions options = {}) {
    options.library = FAKE_HD;
    device = std::make_unique<OpenHaptics>(options);
    return device->open();
  }
  void run() {
    ASSERT_TRUE(open());
    ASSERT_TRUE(device->start(haptic_tick, &haptic));
    wait(3);
  }
  /// Waits for this many ticks of the vendor's thread.
  void wait(int ticks) {
    const int end = arm.ticks + ticks;
    for (int n = 0; n < 5000 && arm.ticks < end; n++)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ASSERT_GE(arm.ticks, end);
  }
  void send(Vec3d force) {
    {
      const std::lock_guard lock(haptic.mutex);
      haptic.output.force = force;
    }
    wait(3);
  }
  DeviceInput last_input() {
    const std::lock_guard lock(haptic.mutex);
    return haptic.input;
  }

  FakeHd& arm = *test::fake<FakeHd>(FAKE_HD, "fake_hd");
  std::unique_ptr<OpenHaptics> device;
  HapticThread haptic;
};

// Forces are converted to the axes of the device.
TEST_F(HdArm, ForceIsMappedToArmAxes) {
  run();
  send({0.1, 0.2, 0.3});
  // Workspace: x right, y away from the user, z up. Device: x right, y up, z towards the user.
  EXPECT_EQ(arm.force[0], 0.1);
  EXPECT_EQ(arm.force[1], 0.3);
  EXPECT_EQ(arm.force[2], -0.2);
  EXPECT_EQ(arm.forces_outside_frames, 0);
}

// Position, velocity and rotation are converted to meters and to the axes of the workspace.
TEST_F(HdArm, MotionIsMappedToWorkspaceAxes) {
  arm.transform[12] = 10, arm.transform[13] = 20, arm.transform[14] = 30;
  // A quarter turn about x, as columns: y maps to z, z to -y.
  const double columns[9] = {1, 0, 0, 0, 0, 1, 0, -1, 0};
  for (std::size_t i = 0; i < 9; i++) arm.transform[i / 3 * 4 + i % 3] = columns[i];
  arm.velocity[1] = 250;
  arm.angular_velocity[2] = 3;
  arm.buttons = 2;
  run();
  const DeviceInput input = last_input();
  EXPECT_NEAR(norm(input.pose.position - Vec3d{0.01, -0.03, 0.02}), 0, 1e-15);
  EXPECT_NEAR(norm(input.velocity - Vec3d{0, 0, 0.25}), 0, 1e-15);
  EXPECT_EQ(input.angular_velocity, (Vec3d{0, -3, 0}));
  EXPECT_EQ(input.buttons, 2u);
  EXPECT_NEAR(norm(input.pose.axes.column[2] - Vec3d{0, -1, 0}), 0,
              1e-15);  // the stylus' z axis points at the user
  EXPECT_TRUE(contact::is_valid(input.pose));
}

// Limits reported by the device are converted to SI units and applied.
TEST_F(HdArm, LimitsAreConvertedToSi) {
  run();
  EXPECT_EQ(device->spec().force, 3.3);
  EXPECT_NEAR(device->spec().stiffness, 400, 1e-9);
  EXPECT_NEAR(device->spec().damping, 5, 1e-9);
  EXPECT_NEAR(norm(device->spec().workspace_low - Vec3d{-0.08, -0.035, -0.06}), 0, 1e-15);
  EXPECT_NEAR(norm(device->spec().workspace_high - Vec3d{0.08, 0.035, 0.06}), 0, 1e-15);
  send({30, 40, 0});
  EXPECT_NEAR(arm.largest_force, 3.3, 1e-12);
  EXPECT_NEAR(-arm.force[2] / arm.force[0], 4.0 / 3, 1e-12);
  send({std::nan(""), 1, 1});
  EXPECT_EQ(std::abs(arm.force[0]) + std::abs(arm.force[1]) + std::abs(arm.force[2]), 0);
}

// Warnings such as warm motors are counted, and forces stay active.
TEST_F(HdArm, WarningsAreCountedAndForcesStay) {
  run();
  for (int n = 0; n < 3; n++) {
    arm.next_error = 0x200;
    wait(3);
  }
  arm.next_error = 0x203;
  wait(3);
  EXPECT_EQ(device->trouble(), "");
  EXPECT_NE(device->remarks().find("warm motors (3 ticks)"), std::string::npos) << device->remarks();
  EXPECT_NE(device->remarks().find("speed above the limit (1 ticks)"), std::string::npos);
  send({1, 0, 0});
  EXPECT_EQ(arm.force[0], 1);
}

// A fault sends zero force, ends the ticks and is reported.
TEST_F(HdArm, FaultStopsForcesAndTicks) {
  run();
  send({1, 0, 0});
  ASSERT_EQ(arm.force[0], 1);
  arm.next_error = 0x302;
  wait(5);
  EXPECT_EQ(arm.force[0], 0);
  EXPECT_NE(device->trouble().find("check cable and power (HD error 0x302)"), std::string::npos)
      << device->trouble();
  const int ticks = haptic.ticks;
  wait(5);
  EXPECT_EQ(haptic.ticks, ticks);
}

// The haptic loop reports a fault with its reason, at once and after its end, and the ticks go on without
// calls.
TEST_F(HdArm, FaultIsReportedByLoop) {
  ASSERT_TRUE(open());
  std::atomic<int> ticks = 0;
  const auto count = [](void* context, std::span<const contact::ToolCommand>, double,
                        std::span<contact::ToolReading>) { ++*static_cast<std::atomic<int>*>(context); };
  auto loop = Loop::start({{.device = device.get()}}, count, &ticks, {.priority = 0, .lock_memory = false});
  ASSERT_TRUE(loop) << loop.error().message;
  wait(20);
  EXPECT_TRUE((*loop)->news().empty());
  arm.next_error = 0x302;
  std::vector<std::string> news;
  for (int n = 0; n < 5000 && news.empty(); n++) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    news = (*loop)->news();
  }
  ASSERT_EQ(news.size(), 1u);
  EXPECT_NE(news[0].find("(HD error 0x302); its forces are off"), std::string::npos) << news[0];
  const int before = ticks;
  for (int n = 0; n < 5000 && ticks < before + 20; n++)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_GE(ticks, before + 20);
  (*loop)->stop();
  ASSERT_EQ((*loop)->notes().size(), 1u);
  EXPECT_NE((*loop)->notes()[0].find("(HD error 0x302)"), std::string::npos) << (*loop)->notes()[0];
}

// A tick with implausible input is skipped and sends zero force.
TEST_F(HdArm, ImplausibleInputSkipsTick) {
  run();
  send({1, 0, 0});
  arm.transform[12] = std::nan("");
  wait(3);
  EXPECT_EQ(arm.force[0], 0);
  const int ticks = haptic.ticks;
  wait(5);
  EXPECT_EQ(haptic.ticks, ticks);
  EXPECT_NE(device->remarks().find("implausible position or speed"), std::string::npos);
  arm.transform[12] = 0;
  wait(3);
  EXPECT_EQ(arm.force[0], 1);
}

// A tick allocates no memory.
TEST_F(HdArm, TickAllocatesNothing) {
  run();
  wait(50);
  {
    const std::lock_guard lock(haptic.mutex);
    haptic.ticks = 0;  // the next tick restarts the count
  }
  wait(50);
  std::size_t counted = 0;
  {
    const std::lock_guard lock(haptic.mutex);
    counted = haptic.allocations;
    haptic.ticks = 0;
  }
  wait(3);
  const std::lock_guard lock(haptic.mutex);
  EXPECT_EQ(haptic.allocations, counted);
}

// Closing sends zero force and ends the thread of the vendor.
TEST_F(HdArm, CloseSendsZeroForceAndJoins) {
  run();
  send({1, 1, 1});
  device->close();
  EXPECT_EQ(arm.force_when_disabled, 0);
  EXPECT_FALSE(arm.is_running);
  EXPECT_FALSE(arm.is_force_on);
  EXPECT_FALSE(arm.is_open);
  device->close();
}

// Opening calibrates the device, or the error states what the user must do.
TEST_F(HdArm, CalibratesOrAsksForCalibration) {
  arm.calibration = 0x5001;
  ASSERT_TRUE(open());
  EXPECT_EQ(arm.updates, 1);
  arm.calibration = 0x5002;
  EXPECT_REFUSED(open({.patience = 0}), "put its stylus into the inkwell");
  EXPECT_FALSE(arm.is_open);
  arm.calibration = 0x5001;
  arm.calibration_styles = 1;  // calibration would reset the encoders at the current position
  EXPECT_REFUSED(open({.patience = 0}), "Touch Setup");
  EXPECT_EQ(arm.updates, 1);
}

// Opening waits until the stylus is in the inkwell.
TEST_F(HdArm, WaitsForInkwellCalibration) {
  arm.calibration = 0x5002;
  std::thread hand([this] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    arm.calibration = 0x5000;
  });
  const Status opened = open({.patience = 10});
  hand.join();
  EXPECT_TRUE(opened);
}

// Errors of the vendor's library are explained when opening fails.
TEST_F(HdArm, OpenErrorsAreExplained) {
  arm.init_error = 0x301;
  EXPECT_REFUSED(open(), "another program uses the device");
  arm.init_error = 0x302;
  EXPECT_REFUSED(open(), "check cable and power");
  arm.init_error = 0;
  arm.max_force = std::nan("");
  EXPECT_REFUSED(open(), "expected a largest force", "nan");
}

// A missing or wrong library is named in the error.
TEST(OpenHaptics, MissingLibraryIsNamed) {
  EXPECT_REFUSED(OpenHaptics({.library = "/nowhere/libHD.so"}).open(), "/nowhere/libHD.so",
                 "install 3D Systems OpenHaptics");
  EXPECT_REFUSED(OpenHaptics({.library = FAKE_DRD}).open(), "lacks the function hdInitDevice");
}

}  // namespace
}  // namespace turgor::haptics
