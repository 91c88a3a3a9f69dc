#include "turgor/haptics/safety.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"

namespace turgor::haptics {

namespace {

Vec3d finite_or_zero(Vec3d v) { return std::isfinite(dot(v, v)) ? v : Vec3d{}; }

DeviceOutput scaled(const DeviceOutput& output, double s) {
  return {output.force * s, output.torque * s, output.grip_force * s};
}

/// Smaller of two limits; zero when either is not positive or not a number.
double smaller_limit(double user, double device) {
  return user > 0 && device > 0 ? std::min(user, device) : 0;
}

DeviceOutput finite_link(Safety& safety, const DeviceOutput& wanted) {
  if (is_finite(wanted)) return wanted;
  safety.counts.not_finite++;
  return {};
}

/// Renders fading damping while the model is silent. Returns true then.
bool silence_link(Safety& safety, const SafetyInput& input, double dt, DeviceOutput& out) {
  const SafetyParams& p = safety.params;
  // the model answers
  if (input.age <= p.silence) {
    safety.silent_time = 0;
    return false;
  }
  // damping, constant and then fading
  safety.counts.silent++;
  safety.silent_time += dt;
  TURGOR_CHECK(p.silent_fade > 0, "damping fades in a positive time");
  const double faded = (safety.silent_time - p.silent_hold) / p.silent_fade;
  const double fraction = std::clamp(1 - faded, 0.0, 1.0);
  out = {.force = input.hand.velocity * (-p.silent_damping * fraction),
         .torque = input.hand.angular_velocity * (-p.silent_angular_damping * fraction)};
  restart_soft_start(safety);
  return true;
}

/// Restarts the soft start after a jump of the hand: lost tracking, a restarted path, or a stalled loop. Any
/// force at the new pose is new.
void jump_link(Safety& safety, const SafetyInput& input) {
  const Passivity& last = safety.passivity;
  if (!last.has_pose || !input.answered) return;
  if (norm(input.hand.pose.position - last.before.position) <= safety.params.jump) return;
  safety.counts.jumped++;
  restart_soft_start(safety);
}

DeviceOutput soft_start_link(Safety& safety, const DeviceOutput& wanted, double dt) {
  const SafetyParams& p = safety.params;
  // full force
  if (safety.start == SoftStart::kFull) return wanted;
  // waiting for a small force
  if (safety.start == SoftStart::kWaiting) {
    safety.counts.waiting++;
    const bool calm = norm(wanted.force) < p.small_force && norm(wanted.torque) < p.small_torque;
    safety.calm = calm ? safety.calm + 1 : 0;
    if (safety.calm >= p.calm_ticks) safety.start = SoftStart::kRamping;
    return {};
  }
  // ramp
  safety.counts.ramping++;
  TURGOR_CHECK(p.ramp > 0, "the force rises in a positive time");
  safety.gain = std::min(1.0, safety.gain + dt / p.ramp);
  if (safety.gain >= 1) safety.start = SoftStart::kFull;
  TURGOR_CHECK(safety.gain >= 0 && safety.gain <= 1, "the gain of a soft start is from 0 to 1");
  return scaled(wanted, safety.gain);
}

DeviceOutput passivity_link(Safety& safety, const SafetyInput& input, const DeviceOutput& wanted, double dt) {
  if (!safety.params.passivity_control) return wanted;
  bool damped = false;
  const DeviceOutput out =
      add_passivity_damping(safety.params.passivity, safety.passivity, wanted, input.hand, dt, damped);
  safety.counts.damped += damped;
  return out;
}

/// Steps from `before` towards `wanted`, by at most `step`.
Vec3d towards(Vec3d before, Vec3d wanted, double step, bool& is_limited) {
  TURGOR_CHECK(step >= 0, "the largest change of a force is not negative");
  const Vec3d displacement = wanted - before;
  const double length = norm(displacement);
  if (length <= step) return wanted;
  is_limited = true;
  return before + displacement * (step / length);  // equals `before` when the difference is not finite
}

DeviceOutput slew_link(Safety& safety, const DeviceOutput& wanted, double dt) {
  const SafetyParams& p = safety.params;
  const DeviceOutput& before = safety.passivity.held_output;
  TURGOR_CHECK(p.rise >= SafetyParams::kSteepest, "the force rises no faster than kSteepest");
  const double fraction = dt / p.rise;
  bool is_limited = false;
  DeviceOutput out{towards(before.force, wanted.force, p.force * fraction, is_limited),
                   towards(before.torque, wanted.torque, p.torque * fraction, is_limited)};
  const double step = p.grip_force * fraction;
  out.grip_force = std::clamp(wanted.grip_force, before.grip_force - step, before.grip_force + step);
  safety.counts.slewed += is_limited || out.grip_force != wanted.grip_force;
  return out;
}

/// Projects onto the limits' ball. A projection keeps the slew limit.
DeviceOutput saturation_link(Safety& safety, const DeviceOutput& wanted) {
  const SafetyParams& p = safety.params;
  const DeviceOutput out =
      within_limits({.force = p.force, .torque = p.torque, .grip_force = p.grip_force}, wanted);
  safety.counts.saturated += norm(wanted.force) > p.force || norm(wanted.torque) > p.torque ||
                             std::abs(wanted.grip_force) > p.grip_force;
  return is_finite(out) ? out : DeviceOutput{};
}

/// True while the device is lost. A device that answers again for some time returns. Its hand may be deep
/// inside a body by then, so its force starts softly. A stalled loop counts for at most a fifth of the time
/// limits, so that the device gets five exchanges.
bool lost_link(Safety& safety, const SafetyInput& input, double dt) {
  const SafetyParams& p = safety.params;
  const auto passed = [dt](double limit) { return dt > 0 ? std::min(dt, limit / 5) : 0; };
  safety.unanswered_time = input.answered ? 0 : safety.unanswered_time + passed(p.lost);
  safety.answered_time = input.answered ? safety.answered_time + passed(p.returned) : 0;
  const bool was_lost = safety.is_lost;
  safety.is_lost = was_lost ? safety.answered_time <= p.returned : safety.unanswered_time > p.lost;
  safety.counts.lost += safety.is_lost;
  if (was_lost || safety.is_lost) restart_soft_start(safety);
  return was_lost || safety.is_lost;
}

}  // namespace

Safety make_safety(const DeviceSpec& spec, const SafetyParams& params, double period) {
  TURGOR_CHECK(period > 0, "a loop has a period");
  // limits of user and device
  Safety safety{.params = params, .period = period};
  SafetyParams& p = safety.params;
  p.force = smaller_limit(p.force, spec.force);
  p.torque = smaller_limit(p.torque, spec.torque);
  p.grip_force = smaller_limit(p.grip_force, spec.grip_force);
  if (!(p.rise >= SafetyParams::kSteepest)) p.rise = SafetyParams::kSteepest;
  p.rise *= std::max(1.0, period / SafetyParams::kSteepest);  // a tick takes the same fraction of the limit
  // damping that the device renders
  const double most = largest_damping(spec, period);
  p.passivity.damping = std::min(p.passivity.damping, most);
  p.silent_damping = std::min(p.silent_damping, most);
  if (p.torque == 0) p.passivity.angular_damping = 0;
  return safety;
}

Safety make_safety(const DeviceSpec& spec, const SafetyParams& params) {
  TURGOR_CHECK(spec.rate > 0, "a device has a rate");
  return make_safety(spec, params, 1 / spec.rate);
}

void restart_soft_start(Safety& safety) {
  safety.start = SoftStart::kWaiting;
  safety.calm = 0;
  safety.gain = 0;
}

SafeOutput make_safe(Safety& safety, const SafetyInput& input, double dt) {
  const double elapsed = dt > 0 ? std::min(dt, 2 * safety.period) : 0;
  // plausible velocities, jump, energy of the last tick
  safety.counts.ticks++;
  SafetyInput tick = input;
  tick.hand.velocity = finite_or_zero(input.hand.velocity);
  tick.hand.angular_velocity = finite_or_zero(input.hand.angular_velocity);
  jump_link(safety, tick);
  if (tick.answered) observe(safety.params.passivity, safety.passivity, tick.hand.pose, elapsed);

  // links in order
  DeviceOutput out = tick.answered ? finite_link(safety, tick.wanted) : DeviceOutput{};
  if (!silence_link(safety, tick, elapsed, out)) out = soft_start_link(safety, out, elapsed);
  out = passivity_link(safety, tick, out, elapsed);
  out = slew_link(safety, out, elapsed);
  out = saturation_link(safety, out);
  if (lost_link(safety, tick, dt)) out = {};
  // the output is held until the next tick
  TURGOR_CHECK(is_finite(out), "forces are finite before they go to a device");
  safety.passivity.held_output = out;
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
