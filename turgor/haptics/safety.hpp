// Between a model and a hand. Whatever a model answers, what a device gets is finite, begins gently, creates
// no energy, does not jump, is no larger than user and device allow, and ends when the model falls silent or
// the device is lost. The links, in the order in which they act:
//
//   not finite    → nothing is asked for in that tick
//   silent        the model's answer is older than `silence`: damping only, later nothing
//   soft start    no force until what is asked for is small, then a ramp; again when the hand jumped
//   passivity     passivity.hpp
//   slew          from tick to tick no more than the limit times dt / rise
//   saturation    the vector, not its components, to the smaller of the user's and the device's limit
//   lost          the device does not answer: nothing, until it is opened again
//
// Silence acts before the slew, so that falling silent is no jump either. SafeOutput is made here alone, and
// the loop gives a device nothing else.
#pragma once

#include <cstdint>

#include "turgor/haptics/passivity.hpp"

namespace turgor::haptics {

struct SafetyParams {
  double force = 10, torque = 0.5, grip_force = 8;  // the user's limits [N] [N·m] [N]
  double rise = 0.005;  // from nothing to the limit, no faster; at least kSteepest [s]
  static constexpr double kSteepest = 0.001;

  double small_force = 0.2, small_torque = 0.01;  // a soft start waits for less than this [N] [N·m]
  int calm_ticks = 3;                             // for so many ticks
  double jump = 0.03;                             // no hand moves so far in a tick [m]
  double ramp = 1;                                // then all of it is felt after [s]

  bool passivity_control = true;
  PassivityParams passivity;  // its dampings are bounded by the device

  double silence = 0.1;  // of the model, from which on it is not trusted [s]
  double silent_damping = 5, silent_angular_damping = 0.02;  // felt instead [N·s/m] [N·m·s/rad]
  double silent_hold = 0.5, silent_fade = 0.5;               // so long, then fading so long [s]

  double lost = 0.05;  // without a word from the device it is given up [s]
};

/// In how many ticks a link changed what was felt.
struct SafetyCounts {
  std::uint64_t ticks = 0;
  std::uint64_t not_finite = 0, silent = 0, waiting = 0, ramping = 0, damped = 0, slewed = 0, saturated = 0,
                lost = 0, jumped = 0;
};

enum class SoftStart : std::uint8_t { kWaiting, kRamping, kFull };

/// Of one device.
struct Safety {
  SafetyParams params;  // bounded by the device
  SafetyCounts counts;
  SoftStart start = SoftStart::kWaiting;
  int calm = 0;           // ticks with little force while waiting
  double gain = 0;        // of the ramp: 0 … 1
  double silent_for = 0;  // beyond params.silence [s]
  double unheard = 0;     // since the device answered [s]
  bool is_lost = false;
  Passivity passivity;
};

/// What a device may be given.
class SafeOutput {
 public:
  SafeOutput() = default;  // nothing
  const DeviceOutput& value() const { return value_; }

 private:
  explicit SafeOutput(const DeviceOutput& value) : value_(value) {}
  friend SafeOutput make_safe(Safety& safety, const struct Asked& asked, double dt);
  DeviceOutput value_;
};

/// A tick as the chain sees it.
struct Asked {
  DeviceInput hand;
  DeviceOutput wanted;   // by the model, in the device's frame
  double age = 0;        // of the model's answer [s]
  bool answered = true;  // the device, in this tick
};

/// Nothing felt yet; the limits are the smaller ones of `params` and of the device.
Safety make_safety(const DeviceSpec& spec, const SafetyParams& params);

/// What the device is to do in the coming tick. `dt` [s] is the time since the last one; a tick that came
/// late counts as two periods at most.
SafeOutput make_safe(Safety& safety, const Asked& asked, double dt);

/// The next force begins softly: after a pause, a clutch, another scene.
void begin_softly(Safety& safety);

/// a + b, link by link.
SafetyCounts operator+(const SafetyCounts& a, const SafetyCounts& b);

}  // namespace turgor::haptics
