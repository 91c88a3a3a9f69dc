#include "turgor/sim/live/live_ticks.hpp"

#include <algorithm>
#include <atomic>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/haptics/rotation.hpp"

namespace turgor {

namespace {

double time_of(const LiveTicks& ticks) { return ticks.start_time + double(ticks.done) * ticks.step; }

/// Command of a tool from its device or from its path. If the device has no gripper, the jaws close while its
/// button is held.
contact::ToolCommand command_of(const LiveTicks& ticks, const TickedTool& ticked, TouchingTool& tool,
                                std::span<const contact::ToolCommand> hands) {
  if (ticked.hand < 0 || (ticked.is_driven && !*ticked.is_driven))
    return next_command(tool, ticks.path_time, ticks.step);
  TURGOR_CHECK(is_index(ticked.hand, hands.size()), "a held tool has a hand");
  contact::ToolCommand command = hands[std::size_t(ticked.hand)];
  if (!ticked.has_grip)
    command.grip = contact::next_grip(tool.grip, command.hold, holding_time(tool), ticks.step);
  tool.grip = command.grip;
  return command;
}

/// Reading of the newest tick of a tool, if it is a needle.
contact::NeedleReading needle_of(const FrameTouchedBody& body, std::size_t t) {
  return body.haptic[t].touch.contact.needle.reading;
}
contact::NeedleReading needle_of(const SfemBody& body, std::size_t t) {
  return body.touch.tools[t].needle ? body.touch.needles.needles[t].reading : contact::NeedleReading{};
}
contact::NeedleReading needle_of(const RhombusBody&, std::size_t) { return {}; }

template <class Body>
void log_body(LiveTicks& ticks, const TickedBody& ticked, Body& body) {
  for (std::size_t t = 0; t < ticked.count; t++) {
    const std::size_t slot = ticked.first + t;
    TickedTool& tool = ticks.order[slot];
    tool.needle = needle_of(body, t);
    log_tick(body, t, sample_of(time_of(ticks), ticks.commands[slot], ticks.readings[slot]),
             ticks.tools[std::size_t(tool.index)]);
    tool.recorded.append({.time = time_of(ticks),
                          .step = ticks.step,
                          .command = ticks.commands[slot],
                          .inputs_used = tick_inputs(body, t)});
  }
}

void tick_body(LiveTicks& ticks, const TickedBody& ticked) {
  TURGOR_CHECK(
      ticked.first + ticked.count <= ticks.commands.size() && ticks.readings.size() == ticks.commands.size(),
      "one command and one reading a tool");
  visit_body(*ticks.world, ticked.id, [&](auto& body) {
    if constexpr (is_touched<decltype(body)>) {
      tick_haptics(body, {&ticks.commands[ticked.first], ticked.count}, ticks.step,
                   {&ticks.readings[ticked.first], ticked.count});
      log_body(ticks, ticked, body);
    }
  });
}

/// Takes one of the allowed ticks; false if there are none. The frame thread may change `allowed`
/// concurrently.
bool consume_tick(std::atomic<long>& allowed) {
  for (long now = allowed; now != 0;)
    if (now < 0 || allowed.compare_exchange_weak(now, now - 1)) return true;
  return false;
}

/// Number of periods that passed since the last tick, at least 1. Frames follow the clock, so the periods of
/// missed ticks count too, unless the number of ticks is limited.
long passed_periods(LiveTicks& ticks, double dt, bool is_limited) {
  TURGOR_CHECK(dt >= 0 && ticks.period > 0, "a loop runs forwards");
  ticks.unspent = is_limited ? ticks.period : std::max(ticks.unspent, -ticks.period) + dt;
  const long passed = std::max(1L, long(ticks.unspent / ticks.period));
  ticks.unspent -= double(passed) * ticks.period;
  return passed;
}

/// Advances the time of paths. A tool on a path does not jump through tissue after missed ticks: until it is
/// in time again, it moves at most twice as fast as its path, and at most kMost of its path per tick.
void advance_paths(LiveTicks& ticks, long passed) {
  constexpr double kMost = 0.01;  // [s]
  TURGOR_CHECK(passed >= 1, "a tick takes at least a period");
  const double most = std::max(2.0, std::min(2.0 * double(passed), kMost / ticks.period));  // [periods]
  ticks.path_time = std::min(time_of(ticks), ticks.path_time + most * ticks.step);
}

/// Advances simulated time to the present tick; false while it is paused. A new pace restarts the count of
/// periods.
bool advance_time(LiveTicks& ticks, double dt) {
  const double step = ticks.period * ticks.pace;
  TURGOR_CHECK(step > 0, "a tick has a positive length");
  const bool is_limited = ticks.allowed >= 0;
  if (ticks.is_paused || !consume_tick(ticks.allowed)) return false;
  if (step != ticks.step) ticks.start_time = time_of(ticks), ticks.done = 0, ticks.step = step;
  const long passed = passed_periods(ticks, dt, is_limited);
  ticks.done += passed;
  advance_paths(ticks, passed);
  return true;
}

/// Publishes the readings of all tools for other threads.
void publish_status(LiveTicks& ticks) {
  std::vector<HapticStatus>& haptic = ticks.haptic.writing();
  TURGOR_CHECK(haptic.size() == ticks.tools.size(), "every tool has a haptic status");
  for (std::size_t slot = 0; slot < ticks.order.size(); slot++)
    haptic[std::size_t(ticks.order[slot].index)] = {ticks.readings[slot], ticks.order[slot].work,
                                                    ticks.order[slot].needle};
  ticks.haptic.publish();
}

/// Adds the work of the tool on the body in this tick, by the trapezoidal rule. A teleport adds none.
void add_work(const contact::ToolCommand& command, const contact::ToolReading& haptic, TickedTool& tool) {
  const contact::Pose& now = command.pose;
  const double longest = haptics::SafetyParams().jump;
  if (const Vec3d displacement = now.position - tool.pose.position;
      tool.has_previous && norm(displacement) < longest) {
    const Vec3d rotation = haptics::rotation_vector(now.axes * transposed(tool.pose.axes));
    tool.work -=
        0.5 * (dot(haptic.force + tool.force, displacement) + dot(haptic.torque + tool.torque, rotation));
  }
  tool.has_previous = true, tool.pose = now, tool.force = haptic.force, tool.torque = haptic.torque;
}

void tick_tools(LiveTicks& ticks, std::span<const contact::ToolCommand> hands,
                std::span<contact::ToolReading> haptic) {
  TURGOR_CHECK(ticks.commands.size() == ticks.order.size() && ticks.readings.size() == ticks.order.size(),
               "one command and one reading a tool");
  // commands
  for (std::size_t slot = 0; slot < ticks.order.size(); slot++) {
    const TickedTool& ticked = ticks.order[slot];
    ticks.commands[slot] = command_of(ticks, ticked, ticks.tools[std::size_t(ticked.index)], hands);
    ticks.readings[slot] = {};
  }

  // ticks
  for (const TickedBody& body : ticks.bodies) tick_body(ticks, body);
  // work
  for (std::size_t slot = 0; slot < ticks.order.size(); slot++)
    add_work(ticks.commands[slot], ticks.readings[slot], ticks.order[slot]);
  // readings for devices and for other threads
  for (std::size_t slot = 0; slot < ticks.order.size(); slot++)
    if (ticks.order[slot].hand >= 0) haptic[std::size_t(ticks.order[slot].hand)] = ticks.readings[slot];
  publish_status(ticks);
}

/// Readings of devices that keep the latest force while time stands still: their tools stay in equilibrium
/// with it, and are not driven into a body that does not answer.
void repeat_readings(const LiveTicks& ticks, std::span<contact::ToolReading> haptic) {
  for (std::size_t slot = 0; slot < ticks.order.size(); slot++)
    if (ticks.order[slot].hand >= 0 && ticks.order[slot].keeps_force)
      haptic[std::size_t(ticks.order[slot].hand)] = ticks.readings[slot];
}

void add_tool(int index, const std::vector<HeldTool>& held, RecordLimits limits, LiveTicks& ticks) {
  TURGOR_CHECK(is_index(index, ticks.tools.size()), "a ticked tool is a tool of the world");
  TickedTool& ticked = ticks.order.emplace_back();
  ticked.index = index;
  ticked.recorded.limit_memory(limits.most, limits.in_memory);
  const auto holder =
      std::find_if(held.begin(), held.end(), [index](const HeldTool& h) { return h.tool == index; });
  if (holder == held.end()) return;
  ticked.hand = int(holder - held.begin());
  ticked.is_driven = holder->is_driven, ticked.keeps_force = holder->keeps_force;
  ticked.has_grip = holder->hand.device->spec().has_grip;
}

}  // namespace

void prepare_ticks(World& world, const std::vector<HeldTool>& held, RecordLimits limits, LiveTicks& ticks) {
  // copy of the tools with bounded logs
  ticks.world = &world;
  ticks.start_time = ticks.path_time = time_of(world);
  ticks.tools = world.tools;
  for (TouchingTool& tool : ticks.tools) tool.samples.preallocate(limits.most, limits.in_memory);

  // bodies and their tools
  for_each_touched(world, [&](BodyId id, auto& body) {
    if (body.tool_indices.empty()) return;
    begin_haptics(body, world.tools);
    if (const Status status = begin_solutions(body, false); !status)
      ticks.notes.push_back(body.name + ": " + status.error().message +
                            "; its nonlinear patch is solved once per frame instead");
    ticks.bodies.push_back({id, ticks.order.size(), body.tool_indices.size()});
    for (const int tool : body.tool_indices) add_tool(tool, held, limits, ticks);
  });
  ticks.commands.resize(ticks.order.size());
  ticks.readings.resize(ticks.order.size());
  for (int slot = 0; slot < 3; slot++) {  // allocates all three buffers before the first tick
    ticks.haptic.write(std::vector<HapticStatus>(world.tools.size()));
    ticks.haptic.read();
  }
}

void save_ticks(LiveTicks& ticks) {
  for (TouchingTool& tool : ticks.tools) tool.samples.save();
  for (TickedTool& tool : ticks.order) tool.recorded.save();
}

void tick_all(void* context, std::span<const contact::ToolCommand> hands, double dt,
              std::span<contact::ToolReading> haptic) {
  LiveTicks& ticks = *static_cast<LiveTicks*>(context);
  for (contact::ToolReading& reading : haptic) reading = {};
  if (advance_time(ticks, dt))
    tick_tools(ticks, hands, haptic);
  else
    repeat_readings(ticks, haptic);
  ticks.loop_count++;
}

}  // namespace turgor
