#include "turgor/sim/live/live_ticks.hpp"

#include <algorithm>
#include <atomic>

#include "turgor/haptics/rotation.hpp"

namespace turgor {

namespace {

double time_of(const LiveTicks& ticks) { return ticks.began + double(ticks.done) * ticks.step; }

/// The hand's, with jaws that close while the button is held where the device has none.
contact::ToolCommand command_of(const LiveTicks& ticks, const TickedTool& ticked, TouchingTool& tool,
                                std::span<const contact::ToolCommand> hands) {
  if (ticked.hand < 0 || (ticked.is_led && !*ticked.is_led)) return next_command(tool, time_of(ticks));
  contact::ToolCommand command = hands[std::size_t(ticked.hand)];
  if (!ticked.has_grip)
    command.grip = contact::next_grip(tool.grip, command.hold, holding_time(tool), ticks.step);
  tool.grip = command.grip;
  return command;
}

template <class Body>
void log_body(LiveTicks& ticks, const TickedBody& ticked, Body& body) {
  for (std::size_t t = 0; t < ticked.count; t++) {
    const std::size_t slot = ticked.first + t;
    TickedTool& tool = ticks.order[slot];
    log_tick(body, t, sample_of(time_of(ticks), ticks.commands[slot], ticks.readings[slot]),
             ticks.tools[std::size_t(tool.index)]);
    if (tool.rows.size() < tool.rows.capacity()) tool.rows.push_back({ticks.step, tick_inputs(body, t)});
  }
}

void tick_body(LiveTicks& ticks, const TickedBody& ticked) {
  visit_body(*ticks.world, ticked.id, [&](auto& body) {
    if constexpr (is_touched<decltype(body)>) {
      tick_haptics(body, {&ticks.commands[ticked.first], ticked.count}, ticks.step,
                   {&ticks.readings[ticked.first], ticked.count});
      log_body(ticks, ticked, body);
    }
  });
}

/// One of the ticks that are left; they may become others meanwhile, or end.
bool take_tick(std::atomic<long>& left) {
  for (long now = left; now != 0;)
    if (now < 0 || left.compare_exchange_weak(now, now - 1)) return true;
  return false;
}

/// Does the world's time pass in this tick? Begins to count anew where its pace is another.
bool goes_on(LiveTicks& ticks) {
  const double step = ticks.period * ticks.pace;
  if (ticks.rests || !take_tick(ticks.left)) return false;
  if (step != ticks.step) ticks.began = time_of(ticks), ticks.done = 0, ticks.step = step;
  ticks.done++;
  return true;
}

/// What every tool feels, for whoever looks on.
void tell_felt(LiveTicks& ticks) {
  std::vector<HapticStatus>& haptic = ticks.haptic.writing();
  for (std::size_t slot = 0; slot < ticks.order.size(); slot++)
    haptic[std::size_t(ticks.order[slot].index)] = {ticks.readings[slot], ticks.order[slot].work};
  ticks.haptic.publish();
}

/// The force on the tool against its way, by the mean of both ends. Where a mouse puts it elsewhere is no
/// way.
void add_work(const contact::ToolCommand& command, const contact::ToolReading& haptic, TickedTool& tool) {
  const contact::Pose& now = command.pose;
  const double longest = haptics::SafetyParams().jump;
  if (const Vec3d way = now.position - tool.pose.position; tool.seen && norm(way) < longest) {
    const Vec3d turn = haptics::rotation_vector(now.axes * transposed(tool.pose.axes));
    tool.work -= 0.5 * (dot(haptic.force + tool.force, way) + dot(haptic.torque + tool.torque, turn));
  }
  tool.seen = true, tool.pose = now, tool.force = haptic.force, tool.torque = haptic.torque;
}

void tick_tools(LiveTicks& ticks, std::span<const contact::ToolCommand> hands,
                std::span<contact::ToolReading> haptic) {
  for (std::size_t slot = 0; slot < ticks.order.size(); slot++) {
    const TickedTool& ticked = ticks.order[slot];
    ticks.commands[slot] = command_of(ticks, ticked, ticks.tools[std::size_t(ticked.index)], hands);
    ticks.readings[slot] = {};
  }
  for (const TickedBody& body : ticks.bodies) tick_body(ticks, body);
  for (std::size_t slot = 0; slot < ticks.order.size(); slot++)
    add_work(ticks.commands[slot], ticks.readings[slot], ticks.order[slot]);
  for (std::size_t slot = 0; slot < ticks.order.size(); slot++)
    if (ticks.order[slot].hand >= 0) haptic[std::size_t(ticks.order[slot].hand)] = ticks.readings[slot];
  tell_felt(ticks);
}

void add_tool(int index, const std::vector<HeldTool>& held, std::size_t most, LiveTicks& ticks) {
  TickedTool& ticked = ticks.order.emplace_back();
  ticked.index = index;
  ticked.rows.reserve(most);
  const auto holder =
      std::find_if(held.begin(), held.end(), [index](const HeldTool& h) { return h.tool == index; });
  if (holder == held.end()) return;
  ticked.hand = int(holder - held.begin());
  ticked.is_led = holder->is_led;
  ticked.has_grip = holder->hand.device->spec().has_grip;
}

}  // namespace

void prepare_ticks(World& world, const std::vector<HeldTool>& held, std::size_t most, LiveTicks& ticks) {
  ticks.world = &world;
  ticks.began = time_of(world);
  ticks.tools = world.tools;
  for (TouchingTool& tool : ticks.tools) tool.samples.preallocate(most);
  for_each_touched(world, [&](BodyId id, auto& body) {
    if (body.tool_indices.empty()) return;
    begin_haptics(body, world.tools);
    ticks.bodies.push_back({id, ticks.order.size(), body.tool_indices.size()});
    for (const int tool : body.tool_indices) add_tool(tool, held, most, ticks);
  });
  ticks.commands.resize(ticks.order.size());
  ticks.readings.resize(ticks.order.size());
  for (int slot = 0; slot < 3; slot++) {  // each of the three has its memory before the first tick
    ticks.haptic.write(std::vector<HapticStatus>(world.tools.size()));
    ticks.haptic.read();
  }
}

void tick_all(void* context, std::span<const contact::ToolCommand> hands, double /*dt*/,
              std::span<contact::ToolReading> haptic) {
  LiveTicks& ticks = *static_cast<LiveTicks*>(context);
  for (contact::ToolReading& reading : haptic) reading = {};
  if (goes_on(ticks)) tick_tools(ticks, hands, haptic);
  ticks.turns++;
}

}  // namespace turgor
