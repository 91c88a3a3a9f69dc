// Safety chain between a model and a hand. Whatever a model returns, the device's force is finite, starts
// gently, creates no energy, does not jump, stays within the limits of user and device, and ends when the
// model stops answering or the device is lost. The links, in order of action:
//
//   not finite    → no force in that tick
//   silent        the model's answer is older than `silence`: damping only, later nothing
//   soft start    no force until the model's force is small, then a ramp; again after a jump of the hand
//   passivity     passivity.hpp
//   slew          change from tick to tick at most the limit times dt / rise
//   saturation    the vector, not its components, to the smaller limit of user and device
//   lost          the device does not answer: no force until it has answered again for `returned`, then a
//                 soft start
//
// Silence acts before slew, so that a model that stops answering causes no jump. Only this chain makes a
// SafeOutput, and the loop sends nothing else to a device.
#pragma once

#include <cstdint>

#include "turgor/haptics/passivity.hpp"

namespace turgor::haptics {

struct SafetyParams {
  double force = 10, torque = 0.5, grip_force = 8;  // the user's limits [N] [N·m] [N]
  double rise = 0.005;  // shortest time from zero to the limit; at least kSteepest, and longer in proportion
                        // if the loop is slower than 1 kHz [s]
  static constexpr double kSteepest = 0.001;

  double small_force = 0.2,
         small_torque = 0.01;  // a soft start waits until force and torque are below these [N] [N·m]
  int calm_ticks = 3;          // for so many ticks
  double jump = 0.03;          // a larger motion of the hand in a tick counts as a jump [m]
  double ramp = 1;             // then the force rises to its full value in this time [s]

  bool passivity_control = true;
  PassivityParams passivity;  // its damping is bounded by the device

  double silence = 0.1;  // age from which the model's answer is not used [s]
  double silent_damping = 5, silent_angular_damping = 0.02;  // rendered instead [N·s/m] [N·m·s/rad]
  double silent_hold = 0.5, silent_fade = 0.5;  // duration of that damping, then of its fading [s]

  double lost = 0.05;      // time without an answer after which the device counts as lost [s]
  double returned = 0.05;  // time with answers after which a lost device returns [s]
};

/// Numbers of ticks in which each link changed the output.
struct SafetyCounts {
  std::uint64_t ticks = 0;
  std::uint64_t not_finite = 0, silent = 0, waiting = 0, ramping = 0, damped = 0, slewed = 0, saturated = 0,
                lost = 0, jumped = 0;
};

enum class SoftStart : std::uint8_t { kWaiting, kRamping, kFull };

/// Safety state of one device.
struct Safety {
  SafetyParams params;    // bounded by the device
  double period = 0.001;  // of the loop [s]
  SafetyCounts counts;
  SoftStart start = SoftStart::kWaiting;
  int calm = 0;                // ticks with a small force while waiting
  double gain = 0;             // of the ramp: 0 … 1
  double silent_time = 0;      // beyond params.silence [s]
  double unanswered_time = 0;  // since the device's last answer [s]
  double answered_time = 0;    // without a missed answer [s]
  bool is_lost = false;
  Passivity passivity;
};

/// Output that has passed the safety chain.
class SafeOutput {
 public:
  SafeOutput() = default;  // no force
  const DeviceOutput& value() const { return value_; }

 private:
  explicit SafeOutput(const DeviceOutput& value) : value_(value) {}
  friend SafeOutput make_safe(Safety& safety, const struct SafetyInput& input, double dt);
  DeviceOutput value_;
};

/// Input of the chain in a tick.
struct SafetyInput {
  DeviceInput hand;
  DeviceOutput wanted;   // model's output, in the device's frame
  double age = 0;        // of the model's answer [s]
  bool answered = true;  // whether the device answered in this tick
};

/// Initial state without force, for a loop with this period [s]. The limits are the smaller ones of `params`
/// and the device.
Safety make_safety(const DeviceSpec& spec, const SafetyParams& params, double period);
/// The same for a loop at the device's design rate.
Safety make_safety(const DeviceSpec& spec, const SafetyParams& params);

/// Output for the coming tick. `dt` [s] is the time since the last tick; a late tick counts as two periods at
/// most.
SafeOutput make_safe(Safety& safety, const SafetyInput& input, double dt);

/// Restarts the soft start: after a pause, a clutch or a change of scene.
void restart_soft_start(Safety& safety);

/// Sum a + b of each count.
SafetyCounts operator+(const SafetyCounts& a, const SafetyCounts& b);

}  // namespace turgor::haptics
