#include "turgor/haptics/ticker.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/haptics/real_time.hpp"

namespace turgor::haptics {

namespace {

using contact::ToolCommand;
using contact::ToolReading;

/// What a device that calls left; false when it has not called for long.
bool read_box(RunningHand& hand, double now) {
  constexpr double kStale = 0.02;  // [s]
  hand.input = hand.box.hand.read();
  return now - hand.box.heard < kStale;
}

void read_hand(Ticker& ticker, RunningHand& hand) {
  const double begin = steady_seconds();
  if (ticker.ticks > 0 && !hand.calls()) ticker.record.latency.add(begin - hand.read);
  const bool answered =
      hand.calls() ? read_box(hand, begin) : hand.hand.device->exchange(hand.output.value(), hand.input);
  hand.answered = answered && contact::is_valid(hand.input.pose);
  hand.read = steady_seconds();
}

/// Where the model finds the tool. `last`: what it answered in the last tick.
ToolCommand tool_command(RunningHand& hand, const ToolReading& last, double dt) {
  ToolCommand out = command(hand.hand.workspace, hand.hand.buttons, hand.clutch, hand.input);
  constexpr double kLongest = 0.002;  // of a tick that came late [s]
  if (!hand.hand.coupling) return out;
  follow(*hand.hand.coupling, out.pose, last, std::min(dt, kLongest), hand.tool);
  out.pose = hand.tool.pose;
  return out;
}

void read_hands(Ticker& ticker, double dt) {
  for (std::size_t h = 0; h < ticker.hands.size(); h++) {
    RunningHand& hand = *ticker.hands[h];
    hand.answered = false;
    if (!hand.safety.is_lost) read_hand(ticker, hand);
    if (hand.answered) ticker.commands[h] = tool_command(hand, ticker.readings[h], dt);
  }
}

/// A model that throws is not asked again.
void ask_model(Ticker& ticker, double dt) {
  const auto nothing = [&] { std::fill(ticker.readings.begin(), ticker.readings.end(), ToolReading{}); };
  nothing();
  if (ticker.stopping || ticker.threw) return;
  try {
    ticker.tick(ticker.context, ticker.commands, dt, ticker.readings);
  } catch (...) {
    nothing();
    ticker.threw = true;
  }
}

DeviceOutput wanted(RunningHand& hand, const ToolReading& reading) {
  if (!hand.clutch.pressed) {
    DeviceOutput out =
        to_device(hand.hand.workspace, hand.hand.coupling ? haptic(hand.tool, reading) : reading);
    if (hand.hand.device->spec().grip_force == 0) out.grip_force = 0;  // nothing there that could squeeze
    return out;
  }
  begin_softly(hand.safety);
  return {};
}

void note_jumps(TimingRecord& record, RunningHand& hand, Vec3d asked, const DeviceOutput& before) {
  const double jump = norm(asked - hand.asked);
  if (std::isfinite(jump)) {
    record.asked_jump = std::max(record.asked_jump, jump);
    hand.asked = asked;
  }
  const DeviceOutput& now = hand.output.value();
  record.force_jump = std::max(record.force_jump, norm(now.force - before.force));
  record.torque_jump = std::max(record.torque_jump, norm(now.torque - before.torque));
}

void answer(Ticker& ticker, RunningHand& hand, const ToolReading& reading, double dt) {
  const Asked asked{
      .hand = hand.input, .wanted = wanted(hand, reading), .age = reading.age, .answered = hand.answered};
  const SafeOutput before = hand.output;
  hand.output = make_safe(hand.safety, asked, dt);
  note_jumps(ticker.record, hand, asked.wanted.force, before.value());
  if (std::isfinite(reading.age)) ticker.record.age.add(reading.age);
  if (hand.safety.is_lost && !hand.lost.exchange(true) && !hand.calls())
    hand.hand.device->exchange(SafeOutput().value(), hand.input);  // should it hear after all
  if (hand.calls()) hand.box.given.write({hand.output, hand.read});
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

bool is_nothing(const DeviceOutput& output) {
  return norm(output.force) == 0 && norm(output.torque) == 0 && output.grip_force == 0;
}

}  // namespace

void publish_report(Ticker& ticker, double now) {
  ticker.reported = now;
  TimingReport out = timing_report(ticker.record);
  out.rate_asked = ticker.rate;
  for (const auto& hand : ticker.hands) {
    out.lowest_energy = std::min(out.lowest_energy, hand->safety.passivity.lowest);
    out.safety = out.safety + hand->safety.counts;
  }
  ticker.report.write(out);
}

bool step(Ticker& ticker) {
  const double begin = steady_seconds();
  const double dt = ticker.ticks > 0 ? begin - ticker.began : 1 / ticker.rate;
  if (ticker.ticks > 0)
    ticker.record.period.add(dt), ticker.record.jitter.add(std::abs(dt - 1 / ticker.rate));
  ticker.began = begin;

  read_hands(ticker, dt);
  const double heard = steady_seconds();
  ask_model(ticker, dt);
  bool haptic = false, heard_of = false;
  for (std::size_t h = 0; h < ticker.hands.size(); h++) {
    RunningHand& hand = *ticker.hands[h];
    answer(ticker, hand, ticker.readings[h], dt);
    publish(ticker, hand, h);
    haptic = haptic || !is_nothing(hand.output.value());
    heard_of = heard_of || !hand.safety.is_lost;
  }
  ticker.ticks++;

  const double end = steady_seconds();
  ticker.record.compute.add(end - heard);
  if (ticker.called) ticker.record.latency.add(end - begin);
  constexpr double kBetweenReports = 0.25;  // [s]
  if (end - ticker.reported > kBetweenReports) publish_report(ticker, end);
  return heard_of && (haptic || !(ticker.stopping || ticker.threw));
}

void let_go(Ticker& ticker) {
  for (const auto& hand : ticker.hands)
    if (!hand->calls() && !hand->safety.is_lost)
      hand->hand.device->exchange(SafeOutput().value(), hand->input);
}

}  // namespace turgor::haptics
