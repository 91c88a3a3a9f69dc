#include "turgor/haptics/virtual_device.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "turgor/haptics/real_time.hpp"
#include "turgor/haptics/rotation.hpp"

namespace turgor::haptics {
namespace {

constexpr double kTick = 1e-3;

/// An arm that is a pure mass.
VirtualArm bare_arm() {
  VirtualArm arm;
  arm.viscous = arm.angular_viscous = arm.coulomb = arm.angular_coulomb = arm.encoder = arm.angular_encoder =
      0;
  arm.velocity_window = 0;
  return arm;
}

DeviceInput run(VirtualDevice& device, int ticks, const DeviceOutput& output = {}) {
  DeviceInput input;
  for (int i = 0; i < ticks; i++) device.exchange(output, input);
  return input;
}

// A constant force moves a mass by a t²/2.
TEST(VirtualDevice, ConstantForceAcceleratesMass) {
  VirtualArm arm = bare_arm();
  arm.mass = 0.2;
  VirtualDevice device(arm);
  ASSERT_TRUE(device.open());
  const DeviceInput input = run(device, 100, {.force = {0.1, -0.05, 0.02}});
  EXPECT_NEAR(input.pose.position.x, 0.5 * 0.1 / 0.2 * 0.01, 1e-12);
  EXPECT_NEAR(input.pose.position.y, 0.5 * -0.05 / 0.2 * 0.01, 1e-12);
  EXPECT_NEAR(input.velocity.z, 0.02 / 0.2 * 0.1, 1e-12);
}

// A free arm without friction conserves its kinetic energy.
TEST(VirtualDevice, FreeArmConservesEnergy) {
  VirtualDevice device(bare_arm());
  ASSERT_TRUE(device.open());
  device.set_motion({}, {0.01, 0.005, 0}, {0, 0.02, 0.01});
  const double before = device.kinetic_energy();
  run(device, 3000);
  EXPECT_NEAR(device.kinetic_energy(), before, 1e-12 * before);
}

// Viscous friction slows the arm exponentially; dry friction stops it in finite time.
TEST(VirtualDevice, FrictionDecaysAndStops) {
  VirtualArm arm = bare_arm();
  arm.viscous = 0.6;
  VirtualDevice viscous(arm);
  ASSERT_TRUE(viscous.open());
  viscous.set_motion({}, {0.1, 0, 0});
  run(viscous, 200);
  EXPECT_NEAR(viscous.velocity().x, 0.1 * std::exp(-0.6 * 0.2 / arm.mass), 1e-12);

  arm = bare_arm();
  arm.coulomb = 0.05;
  VirtualDevice dry(arm);
  ASSERT_TRUE(dry.open());
  dry.set_motion({}, {0.06, -0.08, 0});  // 0.1 m/s, stops after v m/f = 0.3 s and v² m/2f = 15 mm
  run(dry, 299);
  EXPECT_GT(norm(dry.velocity()), 0);
  run(dry, 2);
  EXPECT_EQ(norm(dry.velocity()), 0);
  EXPECT_NEAR(norm(dry.pose().position), 0.015, 1e-5);
  run(dry, 500, {.force = {0.049, 0, 0}});  // less than its friction
  EXPECT_EQ(norm(dry.velocity()), 0);
  run(dry, 500, {.force = {0.06, 0, 0}});
  EXPECT_GT(dry.velocity().x, 0.01);
}

// A hand oscillates about its target like a damped oscillator.
TEST(VirtualDevice, HandIsDampedOscillator) {
  VirtualHand hand{.mass = 0.1, .damping = 0.4, .stiffness = 300};
  VirtualArm arm = bare_arm();
  VirtualDevice device(arm, hand);
  ASSERT_TRUE(device.open());
  device.set_motion({.position = {0.01, 0, 0}, .axes = {}});
  const double m = arm.mass + hand.mass, decay = hand.damping / (2 * m);
  const double omega = std::sqrt(hand.stiffness / m - decay * decay);
  for (int i = 1; i <= 1000; i++) {
    run(device, 1);
    const double t = kTick * i;
    const double exact =
        0.01 * std::exp(-decay * t) * (std::cos(omega * t) + decay / omega * std::sin(omega * t));
    ASSERT_NEAR(device.pose().position.x, exact, 1e-12) << i;
  }
}

// The rotation of a hand oscillates about its target.
TEST(VirtualDevice, RotatingHandIsOscillator) {
  VirtualHand hand{.inertia = 1e-4, .angular_stiffness = 0.5};
  VirtualArm arm = bare_arm();
  VirtualDevice device(arm, hand);
  ASSERT_TRUE(device.open());
  const Vec3d axis{0.6, 0, 0.8};
  device.set_motion({.position = {}, .axes = rotation(axis * 0.3)});
  run(device, 500);
  const double angle = 0.3 * std::cos(std::sqrt(0.5 / 3e-4) * 0.5);
  EXPECT_LT(norm(rotation_vector(device.pose().axes) - axis * angle), 1e-9);
}

// A hand follows a moving target with position, rotation, grip and buttons.
TEST(VirtualDevice, HandFollowsTarget) {
  const auto circle = [](double t) {
    return HandTarget{.pose = {.position = {0.02 * std::sin(t), 0.02 * (1 - std::cos(t)), 0},
                               .axes = rotation({0, 0, 0.3 * t})},
                      .grip = 0.5,
                      .buttons = t > 1 ? 1u : 0u};
  };
  VirtualDevice device({}, light_grip(circle));
  ASSERT_TRUE(device.open());
  const DeviceInput input = run(device, 2000);
  EXPECT_LT(norm(input.pose.position - circle(2).pose.position), 1e-3);
  EXPECT_NEAR(rotation_vector(input.pose.axes).z, 0.6, 0.02);
  EXPECT_EQ(input.grip, 0.5);
  EXPECT_EQ(input.buttons, 1u);
}

// A path is linear between its samples and constant beyond its ends.
TEST(VirtualDevice, PathInterpolatesLinearly) {
  const auto path =
      path_through({{1, {.pose = {.position = {0.01, 0, 0}, .axes = {}}, .buttons = 1}},
                    {3, {.pose = {.position = {0.03, 0.04, 0}, .axes = rotation({0, 0.4, 0})}, .grip = 1}}});
  EXPECT_EQ(path(0).pose.position, (Vec3d{0.01, 0, 0}));
  const HandTarget between = path(1.5);
  EXPECT_LT(norm(between.pose.position - Vec3d{0.015, 0.01, 0}), 1e-12);
  EXPECT_LT(norm(rotation_vector(between.pose.axes) - Vec3d{0, 0.1, 0}), 1e-12);
  EXPECT_NEAR(between.grip, 0.25, 1e-12);
  EXPECT_EQ(between.buttons, 1u);  // buttons change when the next sample is reached
  EXPECT_EQ(path(9).pose.position, (Vec3d{0.03, 0.04, 0}));
  EXPECT_EQ(path(3).buttons, 0u);
}

// The encoder rounds the position to steps; the velocity is their finite difference.
TEST(VirtualDevice, EncoderQuantizesPosition) {
  VirtualArm arm = bare_arm();
  arm.encoder = 1e-4;
  arm.velocity_window = 10;
  VirtualDevice device(arm);
  ASSERT_TRUE(device.open());
  device.set_motion({}, {0.0123, 0, 0});
  for (int i = 0; i < 50; i++) {
    const double steps = run(device, 1).pose.position.x / arm.encoder;
    ASSERT_NEAR(steps, std::round(steps), 1e-9);
    ASSERT_NEAR(device.pose().position.x, steps * arm.encoder, 0.5 * arm.encoder + 1e-12);
  }
  EXPECT_NEAR(run(device, 1).velocity.x, 0.0123, arm.encoder / (10 * kTick));
}

// A force acts after exactly the given number of ticks.
TEST(VirtualDevice, DelayIsExact) {
  for (const int delay : {0, 1, 5}) {
    VirtualArm arm = bare_arm();
    arm.delay = delay;
    VirtualDevice device(arm);
    ASSERT_TRUE(device.open());
    run(device, delay, {.force = {1, 0, 0}});
    EXPECT_EQ(device.velocity().x, 0) << delay;
    run(device, 1, {.force = {1, 0, 0}});
    EXPECT_NEAR(device.velocity().x, kTick / arm.mass, 1e-9) << delay;
  }
}

// Force and position are limited to the range of the device.
TEST(VirtualDevice, ForceAndWorkspaceAreLimited) {
  VirtualArm arm = bare_arm();
  arm.force = 2;
  VirtualDevice device(arm);
  ASSERT_TRUE(device.open());
  run(device, 10, {.force = {30, 40, 0}});
  EXPECT_NEAR(norm(device.velocity()), 2 / arm.mass * 0.01, 1e-9);
  run(device, 1000, {.force = {30, 0, 0}});
  EXPECT_EQ(device.pose().position.x, arm.workspace_high.x);
  EXPECT_EQ(device.velocity().x, 0);
}

// With the clock of the machine the device time follows real time.
TEST(VirtualDevice, ClockFollowsRealTime) {
  VirtualDevice device(bare_arm(), {}, VirtualTime::kClock);
  const double before_open = steady_seconds();
  ASSERT_TRUE(device.open());
  const double after_open = steady_seconds();
  DeviceInput input;
  double last_exchange = 0;
  while (last_exchange < after_open + 0.02) {
    last_exchange = steady_seconds();
    device.exchange({}, input);
  }
  constexpr double kStep = 0.2e-3;
  EXPECT_GE(device.time(), last_exchange - after_open - kStep);
  EXPECT_LE(device.time(), steady_seconds() - before_open);
  EXPECT_LE(std::abs(input.time - before_open - device.time()), after_open - before_open + kStep);
}

// A closed device fails every exchange.
TEST(VirtualDevice, ClosedDeviceFailsExchange) {
  VirtualDevice device(bare_arm());
  DeviceInput input;
  EXPECT_FALSE(device.exchange({}, input));
  ASSERT_TRUE(device.open());
  EXPECT_TRUE(device.exchange({}, input));
  device.close();
  EXPECT_FALSE(device.exchange({}, input));
}

}  // namespace
}  // namespace turgor::haptics
