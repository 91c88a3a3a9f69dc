#include "turgor/haptics/virtual_device.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "turgor/haptics/real_time.hpp"
#include "turgor/haptics/rotation.hpp"

namespace turgor::haptics {
namespace {

constexpr double kTick = 1e-3;

/// Nothing but a mass.
VirtualArm bare() {
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

TEST(virtual_device, a_force_that_is_held_moves_a_mass_by_half_a_t_squared) {
  VirtualArm arm = bare();
  arm.mass = 0.2;
  VirtualDevice device(arm);
  ASSERT_TRUE(device.open());
  const DeviceInput input = run(device, 100, {.force = {0.1, -0.05, 0.02}});
  EXPECT_NEAR(input.pose.position.x, 0.5 * 0.1 / 0.2 * 0.01, 1e-12);
  EXPECT_NEAR(input.pose.position.y, 0.5 * -0.05 / 0.2 * 0.01, 1e-12);
  EXPECT_NEAR(input.velocity.z, 0.02 / 0.2 * 0.1, 1e-12);
}

TEST(virtual_device, an_arm_that_nobody_holds_neither_gains_nor_loses_energy_without_friction) {
  VirtualDevice device(bare());
  ASSERT_TRUE(device.open());
  device.place({}, {0.01, 0.005, 0}, {0, 0.02, 0.01});
  const double before = device.kinetic_energy();
  run(device, 3000);
  EXPECT_NEAR(device.kinetic_energy(), before, 1e-12 * before);
}

TEST(virtual_device, viscous_friction_slows_it_exponentially_and_dry_friction_stops_it_in_time) {
  VirtualArm arm = bare();
  arm.viscous = 0.6;
  VirtualDevice viscous(arm);
  ASSERT_TRUE(viscous.open());
  viscous.place({}, {0.1, 0, 0});
  run(viscous, 200);
  EXPECT_NEAR(viscous.velocity().x, 0.1 * std::exp(-0.6 * 0.2 / arm.mass), 1e-12);

  arm = bare();
  arm.coulomb = 0.05;
  VirtualDevice dry(arm);
  ASSERT_TRUE(dry.open());
  dry.place({}, {0.06, -0.08, 0});  // 0.1 m/s, stops after v m/f = 0.3 s and v² m/2f = 15 mm
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

TEST(virtual_device, a_hand_swings_about_its_target_as_a_damped_oscillator_does) {
  VirtualHand hand{.mass = 0.1, .damping = 0.4, .stiffness = 300};
  VirtualArm arm = bare();
  VirtualDevice device(arm, hand);
  ASSERT_TRUE(device.open());
  device.place({.position = {0.01, 0, 0}, .axes = {}});
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

TEST(virtual_device, a_hand_that_turns_swings_alike) {
  VirtualHand hand{.inertia = 1e-4, .angular_stiffness = 0.5};
  VirtualArm arm = bare();
  VirtualDevice device(arm, hand);
  ASSERT_TRUE(device.open());
  const Vec3d axis{0.6, 0, 0.8};
  device.place({.position = {}, .axes = rotation(axis * 0.3)});
  run(device, 500);
  const double angle = 0.3 * std::cos(std::sqrt(0.5 / 3e-4) * 0.5);
  EXPECT_LT(norm(rotation_vector(device.pose().axes) - axis * angle), 1e-9);
}

TEST(virtual_device, a_hand_follows_its_target) {
  const auto circle = [](double t) {
    return HandTarget{.pose = {.position = {0.02 * std::sin(t), 0.02 * (1 - std::cos(t)), 0},
                               .axes = rotation({0, 0, 0.3 * t})},
                      .grip = 0.5,
                      .buttons = t > 1 ? 1u : 0u};
  };
  VirtualDevice device({}, light_hand(circle));
  ASSERT_TRUE(device.open());
  const DeviceInput input = run(device, 2000);
  EXPECT_LT(norm(input.pose.position - circle(2).pose.position), 1e-3);
  EXPECT_NEAR(rotation_vector(input.pose.axes).z, 0.6, 0.02);
  EXPECT_EQ(input.grip, 0.5);
  EXPECT_EQ(input.buttons, 1u);
}

TEST(virtual_device, a_path_goes_straight_from_sample_to_sample_and_stays_at_its_ends) {
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

TEST(virtual_device, its_encoder_rounds_to_steps_and_velocity_is_their_difference) {
  VirtualArm arm = bare();
  arm.encoder = 1e-4;
  arm.velocity_window = 10;
  VirtualDevice device(arm);
  ASSERT_TRUE(device.open());
  device.place({}, {0.0123, 0, 0});
  for (int i = 0; i < 50; i++) {
    const double steps = run(device, 1).pose.position.x / arm.encoder;
    ASSERT_NEAR(steps, std::round(steps), 1e-9);
    ASSERT_NEAR(device.pose().position.x, steps * arm.encoder, 0.5 * arm.encoder + 1e-12);
  }
  EXPECT_NEAR(run(device, 1).velocity.x, 0.0123, arm.encoder / (10 * kTick));
}

TEST(virtual_device, a_force_acts_so_many_ticks_late_as_it_says) {
  for (const int delay : {0, 1, 5}) {
    VirtualArm arm = bare();
    arm.delay = delay;
    VirtualDevice device(arm);
    ASSERT_TRUE(device.open());
    run(device, delay, {.force = {1, 0, 0}});
    EXPECT_EQ(device.velocity().x, 0) << delay;
    run(device, 1, {.force = {1, 0, 0}});
    EXPECT_NEAR(device.velocity().x, kTick / arm.mass, 1e-9) << delay;
  }
}

TEST(virtual_device, forces_beyond_its_limit_and_ways_beyond_its_workspace_end_there) {
  VirtualArm arm = bare();
  arm.force = 2;
  VirtualDevice device(arm);
  ASSERT_TRUE(device.open());
  run(device, 10, {.force = {30, 40, 0}});
  EXPECT_NEAR(norm(device.velocity()), 2 / arm.mass * 0.01, 1e-9);
  run(device, 1000, {.force = {30, 0, 0}});
  EXPECT_EQ(device.pose().position.x, arm.workspace_high.x);
  EXPECT_EQ(device.velocity().x, 0);
}

TEST(virtual_device, on_the_machines_clock_as_much_time_passes_as_passes) {
  VirtualDevice device(bare(), {}, VirtualTime::kClock);
  const double before_open = steady_seconds();
  ASSERT_TRUE(device.open());
  const double after_open = steady_seconds();
  DeviceInput input;
  double asked = 0;
  while (asked < after_open + 0.02) {
    asked = steady_seconds();
    device.exchange({}, input);
  }
  constexpr double kStep = 0.2e-3;
  EXPECT_GE(device.time(), asked - after_open - kStep);
  EXPECT_LE(device.time(), steady_seconds() - before_open);
  EXPECT_LE(std::abs(input.time - before_open - device.time()), after_open - before_open + kStep);
}

TEST(virtual_device, what_is_closed_does_not_answer) {
  VirtualDevice device(bare());
  DeviceInput input;
  EXPECT_FALSE(device.exchange({}, input));
  ASSERT_TRUE(device.open());
  EXPECT_TRUE(device.exchange({}, input));
  device.close();
  EXPECT_FALSE(device.exchange({}, input));
}

}  // namespace
}  // namespace turgor::haptics
