#include "turgor/haptics/ticker.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/haptics/real_time.hpp"

namespace turgor::haptics {

namespace {

using contact::ToolCommand;
using contact::ToolReading;

/// Reads the hand from its mailbox. False when the device has not called for some time.
bool read_mailbox(RunningHand& hand, double now) {
  hand.input = hand.mailbox.hand.read();
  return now - hand.mailbox.called_at < kStale;
}

void read_hand(Ticker& ticker, RunningHand& hand) {
  const double begin = steady_seconds();
  if (ticker.ticks > 0 && !hand.calls() && !hand.safety.is_lost) ticker.record.latency.add(begin - hand.read);
  const bool answered =
      hand.calls() ? read_mailbox(hand, begin) : hand.hand.device->exchange(hand.output.value(), hand.input);
  hand.answered = answered && contact::is_valid(hand.input.pose);
  hand.read = steady_seconds();
  // a lost device whose calls take longer than a tick delays the other hands by 1 % at most
  constexpr double kRetry = 100;  // pause, as a multiple of the time of the call
  const double taken = hand.read - begin;
  if (hand.safety.is_lost && !hand.answered && taken * ticker.rate > 1)
    hand.retry_at = hand.read + kRetry * taken;
}

/// Command for the model's tool, at the proxy's pose if there is a coupling. `last`: the model's reading of
/// the last tick.
ToolCommand tool_command(RunningHand& hand, const ToolReading& last, double dt) {
  ToolCommand out = command(hand.hand.workspace, hand.hand.buttons, hand.clutch, hand.input);
  if (!hand.hand.coupling) return out;
  const double longest = 2 * hand.safety.period;  // of a late tick [s]
  advance_coupled_tool(*hand.hand.coupling, out.pose, last, std::min(dt, longest), hand.tool);
  out.pose = hand.tool.pose;
  return out;
}

void read_hands(Ticker& ticker, double dt) {
  TURGOR_CHECK(ticker.commands.size() == ticker.hands.size() && ticker.readings.size() == ticker.hands.size(),
               "one command and one reading a hand");
  for (std::size_t h = 0; h < ticker.hands.size(); h++) {
    RunningHand& hand = *ticker.hands[h];
    hand.answered = false;
    if (!hand.safety.is_lost || steady_seconds() >= hand.retry_at) read_hand(ticker, hand);
    if (hand.answered) ticker.commands[h] = tool_command(hand, ticker.readings[h], dt);
    // the proxy of a lost device starts at the hand when it returns, and is not pulled through the body
    if (!hand.answered && hand.safety.is_lost) hand.tool = {};
  }
}

/// Runs the model's tick. A model that threw an exception is not called again.
void call_model(Ticker& ticker, double dt) {
  const auto nothing = [&] { std::fill(ticker.readings.begin(), ticker.readings.end(), ToolReading{}); };
  nothing();
  if (ticker.stopping || ticker.threw) return;
  TURGOR_CHECK(ticker.model_tick != nullptr, "a loop ticks a model");
  try {
    ticker.model_tick(ticker.context, ticker.commands, dt, ticker.readings);
  } catch (...) {
    nothing();
    ticker.threw = true;
  }
}

DeviceOutput desired_output(RunningHand& hand, const ToolReading& reading) {
  if (!hand.clutch.pressed) {
    DeviceOutput out =
        to_device(hand.hand.workspace, hand.hand.coupling ? coupled_reading(hand.tool, reading) : reading);
    if (hand.hand.device->spec().grip_force == 0) out.grip_force = 0;  // the device has no gripper motor
    return out;
  }
  restart_soft_start(hand.safety);
  return {};
}

void record_jumps(TimingRecord& record, RunningHand& hand, Vec3d model_force, const DeviceOutput& before) {
  const double jump = norm(model_force - hand.model_force);
  if (std::isfinite(jump)) {
    record.model_force_jump = std::max(record.model_force_jump, jump);
    hand.model_force = model_force;
  }
  const DeviceOutput& now = hand.output.value();
  record.force_jump = std::max(record.force_jump, norm(now.force - before.force));
  record.torque_jump = std::max(record.torque_jump, norm(now.torque - before.torque));
}

/// Zero force at once to a device that is lost, in case it still receives. Counts losses for other threads.
void note_loss(RunningHand& hand) {
  const bool was_lost = hand.lost.exchange(hand.safety.is_lost);
  if (was_lost || !hand.safety.is_lost) return;
  hand.losses++;
  if (!hand.calls()) hand.hand.device->exchange(SafeOutput().value(), hand.input);
}

void compute_output(Ticker& ticker, RunningHand& hand, const ToolReading& reading, double dt) {
  // the mailbox sent no force while the ticks stood still
  if (hand.calls() && !hand.is_pacer && dt > kStale) hand.safety.passivity.held_output = {};
  // safety chain
  const SafetyInput input{.hand = hand.input,
                          .wanted = desired_output(hand, reading),
                          .age = reading.age,
                          .answered = hand.answered};
  const SafeOutput before = hand.output;
  hand.output = make_safe(hand.safety, input, dt);
  // statistics
  record_jumps(ticker.record, hand, input.wanted.force, before.value());
  if (std::isfinite(reading.age)) ticker.record.age.add(reading.age);
  note_loss(hand);
  // mailbox of a device that calls
  if (hand.calls()) hand.mailbox.output.write({hand.output, hand.read});
}

void publish(const Ticker& ticker, RunningHand& hand, std::size_t index) {
  hand.status.write({.tick = ticker.ticks,
                     .input = hand.input,
                     .command = ticker.commands[index],
                     .reading = ticker.readings[index],
                     .output = hand.output.value(),
                     .energy = hand.safety.passivity.energy,
                     .start = hand.safety.start,
                     .lost = hand.safety.is_lost});
}

bool is_zero(const DeviceOutput& output) {
  return norm(output.force) == 0 && norm(output.torque) == 0 && output.grip_force == 0;
}

}  // namespace

void publish_report(Ticker& ticker, double now) {
  ticker.reported = now;
  TimingReport out = timing_report(ticker.record);
  out.target_rate = ticker.rate;
  for (const auto& hand : ticker.hands) {
    out.lowest_energy = std::min(out.lowest_energy, hand->safety.passivity.lowest);
    out.safety = out.safety + hand->safety.counts;
  }
  ticker.report.write(out);
}

bool run_tick(Ticker& ticker) {
  // timing of the last tick
  const double begin = steady_seconds();
  const double dt = ticker.ticks > 0 ? begin - ticker.began : 1 / ticker.rate;
  if (ticker.ticks > 0)
    ticker.record.period.add(dt), ticker.record.jitter.add(std::abs(dt - 1 / ticker.rate));
  ticker.began = begin;

  // hands, model, outputs
  TURGOR_CHECK(dt >= 0, "the steady clock does not run backwards");
  read_hands(ticker, dt);
  const double hands_read = steady_seconds();
  call_model(ticker, dt);
  bool has_force = false;
  for (std::size_t h = 0; h < ticker.hands.size(); h++) {
    RunningHand& hand = *ticker.hands[h];
    compute_output(ticker, hand, ticker.readings[h], dt);
    publish(ticker, hand, h);
    has_force = has_force || !is_zero(hand.output.value());
  }
  ticker.ticks++;

  // timing of this tick
  const double end = steady_seconds();
  ticker.record.compute.add(end - hands_read);
  if (ticker.is_device_paced) ticker.record.latency.add(end - begin);
  constexpr double kBetweenReports = 0.25;  // [s]
  if (end - ticker.reported > kBetweenReports) publish_report(ticker, end);
  return has_force || !(ticker.stopping || ticker.threw);
}

void send_zero_forces(Ticker& ticker) {
  for (const auto& hand : ticker.hands)
    if (!hand->calls() && !hand->safety.is_lost)
      hand->hand.device->exchange(SafeOutput().value(), hand->input);
}

}  // namespace turgor::haptics
