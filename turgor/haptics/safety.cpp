#include "turgor/haptics/safety.hpp"

#include <algorithm>
#include <cmath>

namespace turgor::haptics {

namespace {

Vec3d finite_or_zero(Vec3d v) { return std::isfinite(dot(v, v)) ? v : Vec3d{}; }

DeviceOutput scaled(const DeviceOutput& output, double s) {
  return {output.force * s, output.torque * s, output.grip_force * s};
}

/// Nothing when either is no number, or below zero.
double smaller_limit(double user, double device) {
  return user > 0 && device > 0 ? std::min(user, device) : 0;
}

DeviceOutput finite_link(Safety& safety, const DeviceOutput& wanted) {
  if (is_finite(wanted)) return wanted;
  safety.counts.not_finite++;
  return {};
}

/// Damping that fades, while the model is silent; true then.
bool silence_link(Safety& safety, const Asked& asked, double dt, DeviceOutput& out) {
  const SafetyParams& p = safety.params;
  if (asked.age <= p.silence) {
    safety.silent_for = 0;
    return false;
  }
  safety.counts.silent++;
  safety.silent_for += dt;
  const double faded = (safety.silent_for - p.silent_hold) / p.silent_fade;
  const double part = std::clamp(1 - faded, 0.0, 1.0);
  out = {.force = asked.hand.velocity * (-p.silent_damping * part),
         .torque = asked.hand.angular_velocity * (-p.silent_angular_damping * part)};
  begin_softly(safety);
  return true;
}

/// Tracking that slipped, a path that starts anew, a loop that slept: whatever is asked for there is new.
void jump_link(Safety& safety, const Asked& asked) {
  const Passivity& last = safety.passivity;
  if (!last.began || !asked.answered) return;
  if (norm(asked.hand.pose.position - last.before.position) <= safety.params.jump) return;
  safety.counts.jumped++;
  begin_softly(safety);
}

DeviceOutput soft_start_link(Safety& safety, const DeviceOutput& wanted, double dt) {
  const SafetyParams& p = safety.params;
  if (safety.start == SoftStart::kFull) return wanted;
  if (safety.start == SoftStart::kWaiting) {
    safety.counts.waiting++;
    const bool calm = norm(wanted.force) < p.small_force && norm(wanted.torque) < p.small_torque;
    safety.calm = calm ? safety.calm + 1 : 0;
    if (safety.calm >= p.calm_ticks) safety.start = SoftStart::kRamping;
    return {};
  }
  safety.counts.ramping++;
  safety.gain = std::min(1.0, safety.gain + dt / p.ramp);
  if (safety.gain >= 1) safety.start = SoftStart::kFull;
  return scaled(wanted, safety.gain);
}

DeviceOutput passivity_link(Safety& safety, const Asked& asked, const DeviceOutput& wanted, double dt) {
  if (!safety.params.passivity_control) return wanted;
  bool damped = false;
  const DeviceOutput out =
      pay_back(safety.params.passivity, safety.passivity, wanted, asked.hand, dt, damped);
  safety.counts.damped += damped;
  return out;
}

/// From `before` towards `wanted`, no farther than `step`.
Vec3d towards(Vec3d before, Vec3d wanted, double step, bool& held) {
  const Vec3d way = wanted - before;
  const double length = norm(way);
  if (length <= step) return wanted;
  held = true;
  return before + way * (step / length);  // nowhere when the way has no finite length
}

DeviceOutput slew_link(Safety& safety, const DeviceOutput& wanted, double dt) {
  const SafetyParams& p = safety.params;
  const DeviceOutput& before = safety.passivity.haptic;
  const double part = dt / p.rise;
  bool held = false;
  DeviceOutput out{towards(before.force, wanted.force, p.force * part, held),
                   towards(before.torque, wanted.torque, p.torque * part, held)};
  const double step = p.grip_force * part;
  out.grip_force = std::clamp(wanted.grip_force, before.grip_force - step, before.grip_force + step);
  safety.counts.slewed += held || out.grip_force != wanted.grip_force;
  return out;
}

/// A projection onto a ball: what was within the slew limit stays there.
DeviceOutput saturation_link(Safety& safety, const DeviceOutput& wanted) {
  const SafetyParams& p = safety.params;
  const DeviceOutput out =
      within_limits({.force = p.force, .torque = p.torque, .grip_force = p.grip_force}, wanted);
  safety.counts.saturated += norm(wanted.force) > p.force || norm(wanted.torque) > p.torque ||
                             std::abs(wanted.grip_force) > p.grip_force;
  return is_finite(out) ? out : DeviceOutput{};
}

/// True while the device is lost. A loop that stalled itself does not blame the device: it asks five times.
bool lost_link(Safety& safety, const Asked& asked, double dt) {
  const double waited = dt > 0 ? std::min(dt, safety.params.lost / 5) : 0;
  safety.unheard = asked.answered ? 0 : safety.unheard + waited;
  safety.is_lost = safety.is_lost || safety.unheard > safety.params.lost;
  safety.counts.lost += safety.is_lost;
  return safety.is_lost;
}

}  // namespace

Safety make_safety(const DeviceSpec& spec, const SafetyParams& params) {
  Safety safety{.params = params};
  SafetyParams& p = safety.params;
  p.force = smaller_limit(p.force, spec.force);
  p.torque = smaller_limit(p.torque, spec.torque);
  p.grip_force = smaller_limit(p.grip_force, spec.grip_force);
  if (!(p.rise >= SafetyParams::kSteepest)) p.rise = SafetyParams::kSteepest;
  const double most = largest_damping(spec, 1 / spec.rate);
  p.passivity.damping = std::min(p.passivity.damping, most);
  p.silent_damping = std::min(p.silent_damping, most);
  if (p.torque == 0) p.passivity.angular_damping = 0;
  return safety;
}

void begin_softly(Safety& safety) {
  safety.start = SoftStart::kWaiting;
  safety.calm = 0;
  safety.gain = 0;
}

SafeOutput make_safe(Safety& safety, const Asked& asked, double dt) {
  constexpr double kLongest = 0.002;  // of a tick that came late [s]
  const double elapsed = dt > 0 ? std::min(dt, kLongest) : 0;
  safety.counts.ticks++;
  Asked tick = asked;
  tick.hand.velocity = finite_or_zero(asked.hand.velocity);
  tick.hand.angular_velocity = finite_or_zero(asked.hand.angular_velocity);
  jump_link(safety, tick);
  if (tick.answered) observe(safety.params.passivity, safety.passivity, tick.hand.pose, elapsed);

  DeviceOutput out = tick.answered ? finite_link(safety, tick.wanted) : DeviceOutput{};
  if (!silence_link(safety, tick, elapsed, out)) out = soft_start_link(safety, out, elapsed);
  out = passivity_link(safety, tick, out, elapsed);
  out = slew_link(safety, out, elapsed);
  out = saturation_link(safety, out);
  if (lost_link(safety, tick, dt)) out = {};
  safety.passivity.haptic = out;
  return SafeOutput(out);
}

SafetyCounts operator+(const SafetyCounts& a, const SafetyCounts& b) {
  return {.ticks = a.ticks + b.ticks,
          .not_finite = a.not_finite + b.not_finite,
          .silent = a.silent + b.silent,
          .waiting = a.waiting + b.waiting,
          .ramping = a.ramping + b.ramping,
          .damped = a.damped + b.damped,
          .slewed = a.slewed + b.slewed,
          .saturated = a.saturated + b.saturated,
          .lost = a.lost + b.lost,
          .jumped = a.jumped + b.jumped};
}

}  // namespace turgor::haptics
