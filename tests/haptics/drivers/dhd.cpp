#include "turgor/haptics/drivers/dhd.hpp"

#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <memory>

#include "tests/allocations.hpp"
#include "tests/folders.hpp"
#include "tests/haptics/drivers/fake_library.hpp"
#include "tests/haptics/fakes/fake_drd.hpp"
#include "tests/refused.hpp"

namespace turgor::haptics {
namespace {

namespace fs = std::filesystem;

/// The fake arm with default settings, and a driver that loads its library.
class DhdArm : public testing::Test {
 protected:
  DhdArm() { arm = {}; }

  Status open(DeviceOptions options = {}) {
    options.library = FAKE_DRD;
    device = std::make_unique<Dhd>(options);
    return device->open();
  }
  bool exchange(Vec3d force = {}) { return device->exchange({.force = force}, input); }

  FakeDrd& arm = *test::fake<FakeDrd>(FAKE_DRD, "fake_drd");
  std::unique_ptr<Dhd> device;
  DeviceInput input;
};

// Forces are converted to the axes of the arm.
TEST_F(DhdArm, ForceIsMappedToArmAxes) {
  ASSERT_TRUE(open());
  // Workspace: x right, y away from the user, z up. Arm: x towards the user, y right, z up.
  ASSERT_TRUE(exchange({1, 2, 3}));
  EXPECT_EQ(arm.force[0], -2);
  EXPECT_EQ(arm.force[1], 1);
  EXPECT_EQ(arm.force[2], 3);
}

// Position, velocity, rotation and grip are converted to the axes of the workspace.
TEST_F(DhdArm, MotionIsMappedToWorkspaceAxes) {
  arm.type = 104;  // sigma.7
  arm.has_wrist = arm.has_active_wrist = arm.has_gripper = true;
  arm.position[0] = -0.01, arm.position[1] = 0.02, arm.position[2] = 0.03;
  arm.velocity[0] = 0.4;
  arm.angular_velocity[1] = 2;
  arm.buttons = 5;
  // The grip is rotated by a quarter turn about the arm's y, the workspace's x: z maps to x, towards the
  // user.
  const double turned[3][3] = {{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}};
  for (int i = 0; i < 3; i++) std::copy_n(turned[i], 3, arm.frame[i]);
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange());
  EXPECT_EQ(input.pose.position, (Vec3d{0.02, 0.01, 0.03}));
  EXPECT_EQ(input.velocity, (Vec3d{0, -0.4, 0}));
  EXPECT_EQ(input.angular_velocity, (Vec3d{2, 0, 0}));
  EXPECT_EQ(input.buttons, 5u);
  EXPECT_EQ(input.pose.axes.column[0], (Vec3d{1, 0, 0}));
  EXPECT_EQ(input.pose.axes.column[2], (Vec3d{0, -1, 0}));  // the grip's z axis points at the user
  EXPECT_NEAR(input.grip, 1, 1e-12);
  arm.gripper_angle = -0.26;  // left hand, half open
  ASSERT_TRUE(exchange());
  EXPECT_NEAR(input.grip, 0.5, 1e-12);
}

// The product of force and velocity is the same in both frames.
TEST_F(DhdArm, AxisMappingKeepsPower) {
  // F·v does not depend on axes: a different mapping of forces and velocities would create or remove energy.
  ASSERT_TRUE(open());
  arm.velocity[0] = 0.1, arm.velocity[1] = -0.2, arm.velocity[2] = 0.3;
  ASSERT_TRUE(exchange({0.5, 1.5, -2.5}));
  const double theirs =
      arm.force[0] * arm.velocity[0] + arm.force[1] * arm.velocity[1] + arm.force[2] * arm.velocity[2];
  EXPECT_NEAR(dot(Vec3d{0.5, 1.5, -2.5}, input.velocity), theirs, 1e-12);
}

// The type of the arm determines the largest force.
TEST_F(DhdArm, ForceIsLimitedByArmType) {
  for (const auto& [type, limit] : std::map<int, double>{{33, 12}, {63, 20}, {60, 8}, {999, 5}}) {
    arm = {};
    arm.type = type;
    ASSERT_TRUE(open());
    EXPECT_EQ(arm.max_force, limit);  // the vendor's own limit too
    ASSERT_TRUE(exchange({300, 400, 0}));
    EXPECT_NEAR(arm.largest_force, limit, 1e-9);
    EXPECT_NEAR(arm.force[1] / -arm.force[0], 0.75, 1e-12);  // the direction is kept
    device->close();
  }
}

// A passive wrist gets no torque; the force of an active gripper is limited.
TEST_F(DhdArm, PassiveAxesGetNoTorque) {
  arm.type = 35;  // omega.7: passive wrist, active gripper
  arm.has_wrist = arm.has_gripper = true;
  ASSERT_TRUE(open());
  ASSERT_TRUE(device->exchange({.torque = {1, 0, 0}, .grip_force = 20}, input));
  EXPECT_EQ(std::hypot(arm.torque[0], arm.torque[1], arm.torque[2]), 0);
  EXPECT_EQ(arm.gripper_force, 8);
}

// A force that is not finite is sent as zero.
TEST_F(DhdArm, NonFiniteForceBecomesZero) {
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange({1, 0, 0}));
  ASSERT_TRUE(exchange({std::nan(""), 0, 5}));
  EXPECT_EQ(std::hypot(arm.force[0], arm.force[1], arm.force[2]), 0);
  ASSERT_TRUE(exchange({std::numeric_limits<double>::infinity(), 0, 0}));
  EXPECT_EQ(std::hypot(arm.force[0], arm.force[1], arm.force[2]), 0);
}

// Velocity threshold, watchdog and gravity compensation of the vendor stay active.
TEST_F(DhdArm, KeepsVendorSafeguards) {
  ASSERT_TRUE(open());
  for (int n = 0; n < 200; n++) exchange();
  EXPECT_EQ(arm.velocity_thresholds, 0);
  EXPECT_EQ(arm.watchdog, 255);  // 32 ms
  EXPECT_TRUE(arm.has_gravity_compensation);
}

// An arm that would move to initialize itself opens only with permission.
TEST_F(DhdArm, AutoInitNeedsPermission) {
  arm.is_initialized = false;
  EXPECT_REFUSED(open(), "moves by itself", "may_move");
  EXPECT_EQ(arm.auto_inits, 0);
  EXPECT_FALSE(arm.is_open);  // the arm was released
  ASSERT_TRUE(open({.may_move = true}));
  EXPECT_EQ(arm.auto_inits, 1);
}

// The exchange with an unplugged arm fails with a message and keeps the last input.
TEST_F(DhdArm, UnpluggedArmFailsExchange) {
  ASSERT_TRUE(open());
  arm.position[1] = 0.02;
  ASSERT_TRUE(exchange({1, 0, 0}));
  EXPECT_EQ(device->trouble(), "");
  arm.is_unplugged = true;
  arm.position[1] = 0.05;
  EXPECT_FALSE(exchange({1, 0, 0}));
  EXPECT_EQ(input.pose.position.x, 0.02);  // unchanged
  EXPECT_NE(device->trouble().find("communication error"), std::string::npos) << device->trouble();
}

// An implausible position fails the exchange and sends zero force until it is valid again.
TEST_F(DhdArm, ImplausibleInputFailsExchange) {
  ASSERT_TRUE(open());
  for (const double wrong : {std::nan(""), 3.0, -1e9}) {
    arm.position[0] = wrong;
    EXPECT_FALSE(exchange({2, 0, 0})) << wrong;
    EXPECT_NE(device->trouble().find("implausible position or speed"), std::string::npos);
    EXPECT_EQ(arm.force[1], 0) << "zero force was sent";
    arm.position[0] = 0;
    EXPECT_TRUE(exchange({2, 0, 0}));
    EXPECT_EQ(device->trouble(), "");
  }
}

// Disabled forces are reported with their cause until the user enables them at the arm.
TEST_F(DhdArm, DisabledForcesAreReported) {
  ASSERT_TRUE(open());
  arm.forces_off_cause = 2;
  bool haptic = true;
  for (int n = 0; n < 64 && haptic; n++) haptic = exchange({3, 0, 0});
  EXPECT_FALSE(haptic);
  EXPECT_NE(device->trouble().find("moved too fast"), std::string::npos) << device->trouble();
  EXPECT_FALSE(exchange());
  arm.forces_off_cause = 0;  // the button
  EXPECT_TRUE(exchange());
}

// After the watchdog has fired, forces resume only when the requested force is small.
TEST_F(DhdArm, ForcesResumeGentlyAfterWatchdog) {
  ASSERT_TRUE(open());
  arm.forces_off_cause = 3;
  bool haptic = true;
  for (int n = 0; n < 64 && haptic; n++) haptic = exchange({3, 0, 0});
  EXPECT_FALSE(haptic);
  EXPECT_FALSE(exchange({3, 0, 0})) << "the full force at once";
  EXPECT_TRUE(exchange({0.1, 0, 0}));
}

// An exchange allocates no memory, even if it fails.
TEST_F(DhdArm, ExchangeAllocatesNothing) {
  ASSERT_TRUE(open());
  const std::size_t before = test::allocations;
  for (int n = 0; n < 100; n++) exchange({1, 0, 0});
  arm.is_unplugged = true;
  for (int n = 0; n < 100; n++) exchange({1, 0, 0});
  EXPECT_EQ(test::allocations, before);
}

// Closing sends zero force before it disables forces; the device can be opened again.
TEST_F(DhdArm, CloseSendsZeroForce) {
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange({1, 2, 3}));
  device->close();
  EXPECT_EQ(arm.force_when_switched_off, 0);
  EXPECT_FALSE(arm.are_forces_on);
  EXPECT_FALSE(arm.is_open);
  device->close();
  EXPECT_FALSE(exchange());
  ASSERT_TRUE(device->open());
  EXPECT_TRUE(exchange());
}

// Arms are numbered from zero; unknown numbers and missing arms are errors.
TEST_F(DhdArm, ArmsAreNumberedFromZero) {
  arm.device_count = 2;
  ASSERT_TRUE(open({.which = "1"}));
  EXPECT_EQ(arm.opened_id, 1);
  EXPECT_REFUSED(open({.which = "2"}), "cannot be opened");
  EXPECT_REFUSED(open({.which = "left"}), "number of an arm", "left");
  arm.device_count = 0;
  EXPECT_REFUSED(open(), "no arm is connected", "udev");
}

// A missing, wrong or invalid library is named in the error.
TEST(Dhd, MissingLibraryIsNamed) {
  EXPECT_REFUSED(Dhd({.library = "/nowhere/libdrd.so"}).open(), "/nowhere/libdrd.so",
                 "install the Force Dimension SDK");
  EXPECT_REFUSED(Dhd({.library = FAKE_HD}).open(), "libfake_hd.so", "lacks the function dhdGetDeviceCount");
  const fs::path text = test::fresh_folder() / "libdrd.so";
  test::write(text, "no library");
  EXPECT_REFUSED(Dhd({.library = text}).open(), "libdrd.so", "file too short");
}

// The library with the highest version in the SDK is loaded.
TEST(Dhd, LoadsNewestSdkVersion) {
  const fs::path sdk = test::fresh_folder(), folder = sdk / "lib/release/lin-x86_64-gcc";
  fs::create_directories(folder);
  test::write(folder / "libdrd.so.3.9.0", "an old one");
  fs::create_symlink(FAKE_DRD, folder / "libdrd.so.3.17.5");
  ASSERT_EQ(setenv("FDSDK", sdk.c_str(), 1), 0);
  const Result<DhdLibrary> dhd = load_dhd({});
  unsetenv("FDSDK");
  ASSERT_TRUE(dhd) << dhd.error().message;
  EXPECT_EQ(dhd->library.file(), (folder / "libdrd.so.3.17.5").string());
  EXPECT_TRUE(dhd->has_drd());
}

}  // namespace
}  // namespace turgor::haptics
