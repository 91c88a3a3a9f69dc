#include "turgor/haptics/z_width.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace turgor::haptics {

namespace {

constexpr double kAbove = 0.005, kPress = 0.3;  // the hand begins so far above, and moves for so long [m] [s]
constexpr double kMargin = 0.005;               // physics sees a wall that is so near [m]

/// From above the wall to `depth` behind it, without a jerk.
HandTarget pressing(double time, double depth) {
  const double way = 0.5 - 0.5 * std::cos(std::numbers::pi * std::min(time / kPress, 1.0));
  return {.pose = {.position = {0, 0, kAbove - (kAbove + depth) * way}, .axes = {}}};
}

/// A wall at z = 0 that pushes and never pulls [N].
double push(const WallTrial& trial, double z, double speed) {
  return z < 0 ? std::max(0.0, -trial.stiffness * z - trial.damping * speed) : 0;
}

/// Physics beside the loop: what it found at its last frame, and at the one before.
struct Physics {
  double force = 0;                     // at the last frame [N]
  bool near_now = false, near = false;  // the wall, at the last frame and the one before
  double next = 0;                      // [s]
};

double answer(const WallTrial& trial, Physics& physics, double time, double z, double speed) {
  if (trial.answer == WallAnswer::kTick) return push(trial, z, speed);
  if (time >= physics.next) {
    physics.next += 1 / trial.frame_rate;
    physics.force = push(trial, z, speed);
    physics.near = physics.near_now;
    physics.near_now = z < kMargin;
  }
  if (trial.answer == WallAnswer::kHeld) return physics.force;
  return physics.near ? push(trial, z, speed) : 0;
}

/// Of a stretch of time.
struct Mean {
  double from, to, sum = 0;
  int count = 0;
  void add(double time, double value) {
    if (time >= from && time < to) sum += value, count++;
  }
  double value() const { return count > 0 ? sum / count : 0; }
};

}  // namespace

WallVerdict press_wall(const WallTrial& trial) {
  VirtualDevice device(trial.arm, {.mass = trial.hand_mass,
                                   .damping = trial.hand_damping,
                                   .stiffness = trial.hand_stiffness,
                                   .target = [&](double time) { return pressing(time, trial.depth); }});
  (void)device.open();
  SafetyParams params{.force = trial.arm.force, .passivity_control = trial.controller};
  params.ramp = 0.01;  // over before the wall is met
  Safety safety = make_safety(device.spec(), params);
  const double dt = 1 / trial.arm.rate;

  Physics physics;
  SafeOutput output;
  Asked asked;
  WallVerdict verdict;
  const double end = trial.seconds;
  Mean early{2 * kPress, 2 * kPress + 0.25 * (end - 2 * kPress)}, late{0.75 * end, end};
  while (device.time() < end) {
    device.exchange(output.value(), asked.hand);
    asked.wanted.force.z =
        answer(trial, physics, device.time(), asked.hand.pose.position.z, asked.hand.velocity.z);
    output = make_safe(safety, asked, dt);
    early.add(device.time(), device.kinetic_energy());
    late.add(device.time(), device.kinetic_energy());
    verdict.largest_force = std::max(verdict.largest_force, output.value().force.z);
  }
  const double mass = trial.arm.mass + trial.hand_mass;
  constexpr double kRest = 0.002;  // what encoder steps alone may keep moving [m/s]
  verdict.early = early.value();
  verdict.late = late.value();
  verdict.speed = std::sqrt(2 * verdict.late / mass);
  verdict.lowest_energy = safety.passivity.lowest;
  verdict.stable = verdict.speed < kRest || verdict.late < 0.25 * verdict.early;
  return verdict;
}

double colgate_stiffness(double arm_viscous, double wall_damping, double period) {
  return 2 * (arm_viscous - std::abs(wall_damping)) / period;
}

double resting_stiffness(double damping, double wall_damping, double period, double delay) {
  return (damping + wall_damping) / (0.5 * period + delay);
}

double quantized_stiffness(double coulomb, double encoder) {
  return encoder > 0 ? 2 * coulomb / encoder : std::numeric_limits<double>::infinity();
}

}  // namespace turgor::haptics
