#include "turgor/haptics/z_width.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "turgor/core/assert.hpp"

namespace turgor::haptics {

namespace {

constexpr double kAbove = 0.005,
                 kPress = 0.3;     // initial height of the hand, and duration of its motion [m] [s]
constexpr double kMargin = 0.005;  // distance at which physics includes the wall [m]

/// Smooth motion from above the wall to `depth` behind it.
HandTarget pressing(double time, double depth) {
  const double fraction = 0.5 - 0.5 * std::cos(std::numbers::pi * std::min(time / kPress, 1.0));
  return {.pose = {.position = {0, 0, kAbove - (kAbove + depth) * fraction}, .axes = {}}};
}

/// Force of a wall at z = 0, which only pushes [N].
double push(const WallTrial& trial, double z, double speed) {
  return z < 0 ? std::max(0.0, -trial.stiffness * z - trial.damping * speed) : 0;
}

/// Physics beside the loop: results of its last frame and of the one before.
struct Physics {
  double force = 0;                     // at the last frame [N]
  bool near_now = false, near = false;  // contact with the wall, at the last frame and the one before
  double next = 0;                      // [s]
};

double wall_force(const WallTrial& trial, Physics& physics, double time, double z, double speed) {
  if (trial.answer == WallAnswer::kTick) return push(trial, z, speed);
  TURGOR_CHECK(trial.frame_rate > 0, "physics has a frame rate");
  if (time >= physics.next) {
    physics.next += 1 / trial.frame_rate;
    physics.force = push(trial, z, speed);
    physics.near = physics.near_now;
    physics.near_now = z < kMargin;
  }
  if (trial.answer == WallAnswer::kHeld) return physics.force;
  return physics.near ? push(trial, z, speed) : 0;
}

/// Mean over a time interval.
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
  // device and safety chain
  VirtualDevice device(trial.arm, {.mass = trial.hand_mass,
                                   .damping = trial.hand_damping,
                                   .stiffness = trial.hand_stiffness,
                                   .target = [&](double time) { return pressing(time, trial.depth); }});
  (void)device.open();
  SafetyParams params{.force = trial.arm.force, .passivity_control = trial.controller};
  params.ramp = 0.01;  // ends before contact with the wall
  Safety safety = make_safety(device.spec(), params);
  const double dt = 1 / trial.arm.rate;

  // mean energies after the press and at the end
  Physics physics;
  SafeOutput output;
  SafetyInput input;
  WallVerdict verdict;
  const double end = trial.seconds;
  Mean early{2 * kPress, 2 * kPress + 0.25 * (end - 2 * kPress)}, late{0.75 * end, end};
  // the loop's ticks
  while (device.time() < end) {
    device.exchange(output.value(), input.hand);
    input.wanted.force.z =
        wall_force(trial, physics, device.time(), input.hand.pose.position.z, input.hand.velocity.z);
    output = make_safe(safety, input, dt);
    early.add(device.time(), device.kinetic_energy());
    late.add(device.time(), device.kinetic_energy());
    verdict.largest_force = std::max(verdict.largest_force, output.value().force.z);
  }
  // verdict
  const double mass = trial.arm.mass + trial.hand_mass;
  constexpr double kRest = 0.002;  // speed that encoder steps alone can sustain [m/s]
  verdict.early = early.value();
  verdict.late = late.value();
  verdict.speed = std::sqrt(2 * verdict.late / mass);
  verdict.lowest_energy = safety.passivity.lowest;
  verdict.stable = verdict.speed < kRest || verdict.late < 0.25 * verdict.early;
  return verdict;
}

double colgate_stiffness(double arm_viscous, double wall_damping, double period) {
  TURGOR_CHECK(period > 0, "a period has a positive length");
  return 2 * (arm_viscous - std::abs(wall_damping)) / period;
}

double resting_stiffness(double damping, double wall_damping, double period, double delay) {
  TURGOR_CHECK(0.5 * period + delay > 0, "a period has a positive length");
  return (damping + wall_damping) / (0.5 * period + delay);
}

double quantized_stiffness(double coulomb, double encoder) {
  TURGOR_CHECK(coulomb >= 0 && encoder >= 0, "friction and resolution are not negative");
  return encoder > 0 ? 2 * coulomb / encoder : std::numeric_limits<double>::infinity();
}

}  // namespace turgor::haptics
