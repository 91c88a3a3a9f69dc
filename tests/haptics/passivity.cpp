#include "turgor/haptics/passivity.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "turgor/haptics/rotation.hpp"
#include "turgor/haptics/safety.hpp"
#include "turgor/haptics/virtual_device.hpp"

namespace turgor::haptics {
namespace {

constexpr double kTick = 1e-3;

contact::Pose at(double z) { return {.position = {0, 0, z}, .axes = {}}; }

/// Slowly down to z and back up: what is left on the account of a spring at 0.
double pressed_and_released(double stiffness, double depth, int ticks, double& deepest) {
  Passivity state;
  PassivityParams params;
  params.reach = 1;
  for (int i = 0; i <= ticks; i++) {
    const double z = -depth * (1 - std::abs(2.0 * i / ticks - 1));
    observe(params, state, at(z), kTick);
    deepest = std::max(deepest, state.energy);
    state.haptic = {.force = {0, 0, -stiffness * z}};
  }
  return state.energy;
}

TEST(passivity, a_pressed_spring_holds_half_k_x_squared_of_the_hands_energy_and_gives_it_back) {
  double deepest = 0;
  const double left = pressed_and_released(400, 0.02, 4000, deepest);
  EXPECT_NEAR(deepest, 0.5 * 400 * 0.02 * 0.02, 1e-3 * 0.08);
  EXPECT_NEAR(left, 0, 1e-3 * 0.08);
}

TEST(passivity, what_holding_a_force_gives_away_is_k_x_times_a_step) {
  // Colgate: a held spring lags half a tick both ways, so a cycle of N steps of Δx yields 2 · N/2 · K Δx²/2.
  const int ticks = 200;
  double deepest = 0;
  const double step = 2 * 0.02 / ticks;
  EXPECT_NEAR(pressed_and_released(400, 0.02, ticks, deepest), -0.5 * ticks * 400 * step * step, 1e-9);
}

TEST(passivity, friction_is_energy_taken_and_a_push_is_energy_given) {
  PassivityParams params;
  params.debt = 1;
  for (const double sign : {-1.0, 1.0}) {  // of the force along the motion
    Passivity state;
    for (int i = 0; i <= 100; i++) {
      observe(params, state, at(1e-4 * i), kTick);
      state.haptic = {.force = {0, 0, sign * 2}};
    }
    EXPECT_NEAR(state.energy, sign < 0 ? 0.02 : -0.02, 1e-12);
  }
}

TEST(passivity, a_lever_that_gives_by_turning_what_it_takes_by_moving_owes_nothing) {
  PassivityParams params;
  params.reach = params.angular_reach = 10;
  Passivity state;
  for (int i = 0; i <= 100; i++) {
    const Vec3d turn{0, 0, 2e-3 * i};
    observe(params, state, {.position = {1e-3 * i, 0, 0}, .axes = rotation(turn)}, kTick);
    EXPECT_NEAR(state.energy, 0, 1e-12);
    state.haptic = {.force = {-2, 0, 0}, .torque = {0, 0, 1}};  // −2 N·1 mm + 1 N·m·2 mrad = 0
  }
}

TEST(passivity, rubbing_for_long_buys_no_more_than_a_body_can_give_back) {
  PassivityParams params;
  Passivity state;
  for (int i = 0; i < 100000; i++) {
    observe(params, state, at(1e-4 * i), kTick);
    state.haptic = {.force = {0, 0, -2}};
  }
  EXPECT_NEAR(state.energy, 2 * params.reach, 1e-12);
  state.haptic = {};
  observe(params, state, at(10), kTick);
  EXPECT_EQ(state.energy, 0);
}

TEST(passivity, the_damping_pays_exactly_what_is_owed_and_is_bounded) {
  PassivityParams params;
  Passivity state;
  const DeviceInput hand{.pose = {}, .velocity = {0.1, 0, 0}};
  bool damped = false;
  state.energy = -2e-5;
  DeviceOutput out = pay_back(params, state, {.force = {0, 1, 0}}, hand, kTick, damped);
  EXPECT_TRUE(damped);
  EXPECT_NEAR(-out.force.x * 0.1 * kTick, 2e-5, 1e-12);
  EXPECT_EQ(out.force.y, 1);
  state.energy = -1;
  out = pay_back(params, state, {}, hand, kTick, damped);
  EXPECT_NEAR(out.force.x, -params.damping * 0.1, 1e-12);
  state.energy = 1;
  pay_back(params, state, {}, hand, kTick, damped);
  EXPECT_FALSE(damped);
}

/// A hand at rest beside a model; where it is after `seconds` [m].
template <class Model>
double swing(Model&& model, bool control, double seconds = 3) {
  VirtualArm arm;
  arm.coulomb = 0;
  VirtualDevice device(arm, light_hand([](double) { return HandTarget{}; }));
  (void)device.open();
  device.place(at(0.002));
  SafetyParams params{.force = 12, .ramp = 1e-3, .passivity_control = control};
  Safety safety = make_safety(device.spec(), params);
  SafeOutput output;
  Asked asked;
  double widest = 0;
  while (device.time() < seconds) {
    device.exchange(output.value(), asked.hand);
    asked.wanted.force = model(asked.hand);
    output = make_safe(safety, asked, kTick);
    if (device.time() > seconds - 0.5) widest = std::max(widest, norm(device.pose().position));
  }
  return widest;
}

TEST(passivity, a_model_that_pushes_along_with_the_hand_is_held_and_without_the_controller_it_is_not) {
  const auto active = [](const DeviceInput& hand) {
    return hand.velocity * 6.0;
  };  // more than hand and arm damp
  EXPECT_GT(swing(active, false), 0.02);
  EXPECT_LT(swing(active, true), 0.003);
}

TEST(passivity, a_model_that_turns_along_with_the_hand_is_held_and_without_the_controller_it_is_not) {
  for (const bool control : {false, true}) {
    VirtualArm arm;
    arm.angular_coulomb = 0;
    VirtualDevice device(arm, light_hand([](double) { return HandTarget{}; }));
    (void)device.open();
    device.place({.position = {}, .axes = rotation({0, 0.02, 0})});
    Safety safety = make_safety(device.spec(), {.torque = 0.4, .ramp = 1e-3, .passivity_control = control});
    SafeOutput output;
    Asked asked;
    double widest = 0;
    while (device.time() < 3) {
      device.exchange(output.value(), asked.hand);
      asked.wanted.torque = asked.hand.angular_velocity * 8e-3;  // hand and arm damp 5.5e-3
      output = make_safe(safety, asked, kTick);
      if (device.time() > 2.5) widest = std::max(widest, norm(rotation_vector(device.pose().axes)));
    }
    EXPECT_EQ(widest < 0.03, control) << widest;
  }
}

TEST(passivity, a_stiff_spring_that_answers_late_is_held_and_without_the_controller_it_is_not) {
  std::array<double, 8> heard{};
  int tick = 0;
  const auto late = [&](const DeviceInput& hand) {
    heard[std::size_t(tick % 8)] = hand.pose.position.z;
    return Vec3d{0, 0, -1500 * heard[std::size_t(++tick % 8)]};  // seven ticks late
  };
  const double free = swing(late, false);
  heard = {}, tick = 0;
  const double held = swing(late, true);
  EXPECT_GT(free, 0.004);
  EXPECT_LT(held, 0.5 * free);
}

TEST(passivity, damping_stays_within_what_device_and_period_bear) {
  DeviceSpec spec{.damping = 30, .mass = 0.2};
  EXPECT_EQ(largest_damping(spec, 1e-3), 30);
  EXPECT_EQ(largest_damping(spec, 1e-2), 10);  // m / 2T
  EXPECT_EQ(largest_damping({}, 1e-3), 10);
}

}  // namespace
}  // namespace turgor::haptics
