#include "turgor/sim/live/driven_ticks.hpp"

namespace turgor {

namespace {

/// visit(body, first of LedTicks::tools) for every body that tools touch.
template <class AnyWorld, class Visit>
void for_each_led(AnyWorld& world, const Visit& visit) {
  std::size_t first = 0;
  for_each_touched(world, [&](BodyId, auto& body) {
    if (body.tool_indices.empty()) return;
    visit(body, first);
    first += body.tool_indices.size();
  });
}

/// begin_felt asks where tools are at the beginning of their paths.
std::vector<TouchingTool> resting(const World& world) {
  std::vector<TouchingTool> tools;
  for (const TouchingTool& tool : world.tools) {
    TouchingTool& rests = tools.emplace_back();
    rests.tool = tool.tool, rests.forceps = tool.forceps;
    rests.hand = {{0, command_at(tool, time_of(world))}};
  }
  return tools;
}

void log_ticks(World& world, const LedTicks& led) {
  for_each_led(world, [&](auto& body, std::size_t first) {
    for (std::size_t t = 0; t < body.tool_indices.size(); t++) {
      const std::size_t slot = first + t;
      log_tick(body, t, sample_of(time_of(led), led.commands[slot], led.readings[slot]),
               world.tools[std::size_t(led.tools[slot])]);
    }
  });
}

/// Frames whose time is over.
Status make_frames(const Exec& exec, World& world, const LedTicks& led) {
  while ((world.frame + 1) * world.dt <= time_of(led) + 1e-9) {
    for_each_led(world, [](auto& body, std::size_t) { expect_patch(body, true); });
    const Result<FrameReport> done = step(exec, world);
    if (!done) return done.error();
    if (!done->finite) return Error{"the numbers of a step were not finite; the state before it was kept"};
  }
  return Done{};
}

}  // namespace

LedTicks begin_led(World& world) {
  LedTicks led;
  led.began = time_of(world);
  const std::vector<TouchingTool> tools = resting(world);
  for_each_led(world, [&](auto& body, std::size_t) {
    begin_haptics(body, tools);
    led.tools.insert(led.tools.end(), body.tool_indices.begin(), body.tool_indices.end());
  });
  for (const int tool : led.tools) led.grip.push_back(world.tools[std::size_t(tool)].grip);
  led.commands.resize(led.tools.size());
  led.readings.resize(led.tools.size());
  return led;
}

void end_led(World& world) {
  for_each_led(world, [](auto& body, std::size_t) { end_haptics(body); });
}

void tick_tools(World& world, LedTicks& led, std::span<const contact::ToolCommand> commands,
                std::span<contact::ToolReading> readings) {
  TURGOR_ASSERT(commands.size() == world.tools.size() && readings.size() == world.tools.size(),
                "a tick has a command and a reading for every tool");
  led.done++;
  for (std::size_t slot = 0; slot < led.tools.size(); slot++) {
    const auto index = std::size_t(led.tools[slot]);
    led.grip[slot] =
        contact::next_grip(led.grip[slot], commands[index].hold, holding_time(world.tools[index]), kTick);
    led.commands[slot] = commands[index];
    led.commands[slot].grip = led.grip[slot];
    led.readings[slot] = {};
  }
  for_each_led(world, [&](auto& body, std::size_t first) {
    const std::size_t count = body.tool_indices.size();
    tick_haptics(body, std::span<const contact::ToolCommand>(led.commands).subspan(first, count), kTick,
                 std::span(led.readings).subspan(first, count));
  });
  for (std::size_t slot = 0; slot < led.tools.size(); slot++)
    readings[std::size_t(led.tools[slot])] = led.readings[slot];
}

Status tick_led(const Exec& exec, World& world, LedTicks& led, std::span<const contact::ToolCommand> commands,
                std::span<contact::ToolReading> readings) {
  tick_tools(world, led, commands, readings);
  log_ticks(world, led);
  return make_frames(exec, world, led);
}

}  // namespace turgor
