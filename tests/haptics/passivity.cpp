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

/// Energy balance after a spring at 0 was slowly pressed to `depth` and released [J].
double pressed_and_released(double stiffness, double depth, int ticks, double& deepest) {
  Passivity state;
  PassivityParams params;
  params.reach = 1;
  for (int i = 0; i <= ticks; i++) {
    const double z = -depth * (1 - std::abs(2.0 * i / ticks - 1));
    observe(params, state, at(z), kTick);
    deepest = std::max(deepest, state.energy);
    state.held_output = {.force = {0, 0, -stiffness * z}};
  }
  return state.energy;
}

// A slowly pressed spring stores k x²/2 and returns it.
TEST(Passivity, SlowSpringReturnsEnergy) {
  double deepest = 0;
  const double residual = pressed_and_released(400, 0.02, 4000, deepest);
  EXPECT_NEAR(deepest, 0.5 * 400 * 0.02 * 0.02, 1e-3 * 0.08);
  EXPECT_NEAR(residual, 0, 1e-3 * 0.08);
}

// A force that is held for a tick generates the energy that Colgate derives.
TEST(Passivity, HeldForceGeneratesEnergy) {
  // Colgate: a held spring lags by half a tick in both directions. A cycle of N steps of Δx yields 2 · N/2 ·
  // K Δx²/2.
  const int ticks = 200;
  double deepest = 0;
  const double step = 2 * 0.02 / ticks;
  EXPECT_NEAR(pressed_and_released(400, 0.02, ticks, deepest), -0.5 * ticks * 400 * step * step, 1e-9);
}

// Friction takes energy from the hand; a push gives energy.
TEST(Passivity, FrictionTakesPushGives) {
  PassivityParams params;
  params.debt = 1;
  for (const double sign : {-1.0, 1.0}) {  // sign of the force along the motion
    Passivity state;
    for (int i = 0; i <= 100; i++) {
      observe(params, state, at(1e-4 * i), kTick);
      state.held_output = {.force = {0, 0, sign * 2}};
    }
    EXPECT_NEAR(state.energy, sign < 0 ? 0.02 : -0.02, 1e-12);
  }
}

// Work of the force and opposite work of the torque cancel in the energy balance.
TEST(Passivity, ForceAndTorqueWorkCancel) {
  PassivityParams params;
  params.reach = params.angular_reach = 10;
  Passivity state;
  for (int i = 0; i <= 100; i++) {
    const Vec3d turn{0, 0, 2e-3 * i};
    observe(params, state, {.position = {1e-3 * i, 0, 0}, .axes = rotation(turn)}, kTick);
    EXPECT_NEAR(state.energy, 0, 1e-12);
    state.held_output = {.force = {-2, 0, 0}, .torque = {0, 0, 1}};  // −2 N·1 mm + 1 N·m·2 mrad = 0
  }
}

// Long rubbing stores no more energy than a body can return within its reach.
TEST(Passivity, StoredEnergyIsBounded) {
  PassivityParams params;
  Passivity state;
  for (int i = 0; i < 100000; i++) {
    observe(params, state, at(1e-4 * i), kTick);
    state.held_output = {.force = {0, 0, -2}};
  }
  EXPECT_NEAR(state.energy, 2 * params.reach, 1e-12);
  state.held_output = {};
  observe(params, state, at(10), kTick);
  EXPECT_EQ(state.energy, 0);
}

// The damping dissipates exactly the generated energy, up to its bound.
TEST(Passivity, DampingMatchesDebt) {
  PassivityParams params;
  Passivity state;
  const DeviceInput hand{.pose = {}, .velocity = {0.1, 0, 0}};
  bool damped = false;
  state.energy = -2e-5;
  DeviceOutput out = add_passivity_damping(params, state, {.force = {0, 1, 0}}, hand, kTick, damped);
  EXPECT_TRUE(damped);
  EXPECT_NEAR(-out.force.x * 0.1 * kTick, 2e-5, 1e-12);
  EXPECT_EQ(out.force.y, 1);
  state.energy = -1;
  out = add_passivity_damping(params, state, {}, hand, kTick, damped);
  EXPECT_NEAR(out.force.x, -params.damping * 0.1, 1e-12);
  state.energy = 1;
  add_passivity_damping(params, state, {}, hand, kTick, damped);
  EXPECT_FALSE(damped);
}

/// Largest distance of a hand from the origin in the last half second, beside a model [m].
template <class Model>
double amplitude(Model&& model, bool control, double seconds = 3) {
  VirtualArm arm;
  arm.coulomb = 0;
  VirtualDevice device(arm, light_grip([](double) { return HandTarget{}; }));
  (void)device.open();
  device.set_motion(at(0.002));
  SafetyParams params{.force = 12, .ramp = 1e-3, .passivity_control = control};
  Safety safety = make_safety(device.spec(), params);
  SafeOutput output;
  SafetyInput input;
  double widest = 0;
  while (device.time() < seconds) {
    device.exchange(output.value(), input.hand);
    input.wanted.force = model(input.hand);
    output = make_safe(safety, input, kTick);
    if (device.time() > seconds - 0.5) widest = std::max(widest, norm(device.pose().position));
  }
  return widest;
}

// The controller stabilizes a model that pushes along the motion of the hand.
TEST(Passivity, ControllerHoldsActiveModel) {
  const auto active = [](const DeviceInput& hand) {
    return hand.velocity * 6.0;
  };  // more than hand and arm dissipate
  EXPECT_GT(amplitude(active, false), 0.02);
  EXPECT_LT(amplitude(active, true), 0.003);
}

// The controller stabilizes a model that turns along the rotation of the hand.
TEST(Passivity, ControllerHoldsActiveTorque) {
  for (const bool control : {false, true}) {
    VirtualArm arm;
    arm.angular_coulomb = 0;
    VirtualDevice device(arm, light_grip([](double) { return HandTarget{}; }));
    (void)device.open();
    device.set_motion({.position = {}, .axes = rotation({0, 0.02, 0})});
    Safety safety = make_safety(device.spec(), {.torque = 0.4, .ramp = 1e-3, .passivity_control = control});
    SafeOutput output;
    SafetyInput input;
    double widest = 0;
    while (device.time() < 3) {
      device.exchange(output.value(), input.hand);
      input.wanted.torque = input.hand.angular_velocity * 8e-3;  // hand and arm dissipate 5.5e-3
      output = make_safe(safety, input, kTick);
      if (device.time() > 2.5) widest = std::max(widest, norm(rotation_vector(device.pose().axes)));
    }
    EXPECT_EQ(widest < 0.03, control) << widest;
  }
}

// The controller at least halves the oscillation of a stiff spring with delay.
TEST(Passivity, ControllerHoldsDelayedSpring) {
  std::array<double, 8> history{};
  int tick = 0;
  const auto late = [&](const DeviceInput& hand) {
    history[std::size_t(tick % 8)] = hand.pose.position.z;
    return Vec3d{0, 0, -1500 * history[std::size_t(++tick % 8)]};  // delayed by seven ticks
  };
  const double free = amplitude(late, false);
  history = {}, tick = 0;
  const double held = amplitude(late, true);
  EXPECT_GT(free, 0.004);
  EXPECT_LT(held, 0.5 * free);
}

// Device and tick period limit the damping to m/(2T).
TEST(Passivity, DampingLimitOfDeviceAndPeriod) {
  DeviceSpec spec{.damping = 30, .mass = 0.2};
  EXPECT_EQ(largest_damping(spec, 1e-3), 30);
  EXPECT_EQ(largest_damping(spec, 1e-2), 10);  // m / 2T
  EXPECT_EQ(largest_damping({}, 1e-3), 10);
}

}  // namespace
}  // namespace turgor::haptics
