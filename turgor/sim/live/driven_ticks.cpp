#include "turgor/sim/live/driven_ticks.hpp"

#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor {

namespace {

/// Calls visit(body, first) for every touched body; `first` is the index of its first tool in
/// DrivenTicks::tools.
template <class AnyWorld, class Visit>
void for_each_driven_body(AnyWorld& world, const Visit& visit) {
  std::size_t first = 0;
  for_each_touched(world, [&](BodyId, auto& body) {
    if (body.tool_indices.empty()) return;
    visit(body, first);
    first += body.tool_indices.size();
  });
}

/// Copies of the tools that stay at their present positions; begin_haptics takes the first pose of a path
/// from them.
std::vector<TouchingTool> tools_at_rest(const World& world) {
  std::vector<TouchingTool> tools;
  for (const TouchingTool& tool : world.tools) {
    TouchingTool& rests = tools.emplace_back();
    rests.tool = tool.tool, rests.forceps = tool.forceps;
    rests.hand = {{0, command_at(tool, time_of(world))}};
  }
  return tools;
}

/// Copies of what moves the tools.
std::shared_ptr<const std::vector<TouchingTool>> paths_of(const World& world) {
  std::vector<TouchingTool> paths;
  for (const TouchingTool& tool : world.tools) {
    TouchingTool& moved = paths.emplace_back();
    moved.path = tool.path, moved.hand = tool.hand, moved.grip = tool.grip;
  }
  return std::make_shared<const std::vector<TouchingTool>>(std::move(paths));
}

void log_ticks(World& world, const DrivenTicks& driven) {
  for_each_driven_body(world, [&](auto& body, std::size_t first) {
    for (std::size_t t = 0; t < body.tool_indices.size(); t++) {
      const std::size_t slot = first + t;
      log_tick(body, t, sample_of(time_of(driven), driven.commands[slot], driven.readings[slot]),
               world.tools[std::size_t(driven.tools[slot])]);
    }
  });
}

/// Steps all frames that are due.
Status step_due_frames(const Exec& exec, World& world, const DrivenTicks& driven) {
  TURGOR_CHECK(is_step_length(world.dt), "a frame has a positive length");
  while ((world.frame + 1) * world.dt <= time_of(driven) + 1e-9) {
    for_each_driven_body(world, [](auto& body, std::size_t) { expect_patch(body, true); });
    const Result<FrameReport> done = step(exec, world);
    if (!done) return done.error();
    if (!done->finite) return Error{"a step was not finite; the state before it was kept"};
  }
  return Done{};
}

}  // namespace

DrivenTicks begin_driven(World& world) {
  DrivenTicks driven;
  driven.began = time_of(world), driven.paths = paths_of(world);
  const std::vector<TouchingTool> tools = tools_at_rest(world);
  for_each_driven_body(world, [&](auto& body, std::size_t) {
    begin_haptics(body, tools);
    driven.tools.insert(driven.tools.end(), body.tool_indices.begin(), body.tool_indices.end());
  });
  for (const int tool : driven.tools) driven.grip.push_back(world.tools[std::size_t(tool)].grip);
  driven.commands.resize(driven.tools.size());
  driven.readings.resize(driven.tools.size());
  return driven;
}

void end_driven(World& world) {
  for_each_driven_body(world, [](auto& body, std::size_t) { end_haptics(body); });
}

contact::ToolCommand path_command(const DrivenTicks& driven, std::size_t tool, double time) {
  TURGOR_ASSERT(driven.paths && tool < driven.paths->size(), "a tool of the world has a path");
  return command_at((*driven.paths)[tool], time);
}

void tick_tools(World& world, DrivenTicks& driven, std::span<const contact::ToolCommand> commands,
                std::span<contact::ToolReading> readings) {
  TURGOR_ASSERT(commands.size() == world.tools.size() && readings.size() == world.tools.size(),
                "a tick has a command and a reading for every tool");
  TURGOR_CHECK(driven.commands.size() == driven.tools.size() &&
                   driven.readings.size() == driven.tools.size() && driven.grip.size() == driven.tools.size(),
               "one command, one reading and one grip a tool");
  TURGOR_CHECK(all_indices(driven.tools, world.tools.size()), "driven tools are tools of the world");
  driven.done++;
  for (std::size_t slot = 0; slot < driven.tools.size(); slot++) {
    const auto index = std::size_t(driven.tools[slot]);
    driven.grip[slot] =
        contact::next_grip(driven.grip[slot], commands[index].hold, holding_time(world.tools[index]), kTick);
    driven.commands[slot] = commands[index];
    driven.commands[slot].grip = driven.grip[slot];
    driven.readings[slot] = {};
  }
  for_each_driven_body(world, [&](auto& body, std::size_t first) {
    const std::size_t count = body.tool_indices.size();
    tick_haptics(body, std::span<const contact::ToolCommand>(driven.commands).subspan(first, count), kTick,
                 std::span(driven.readings).subspan(first, count));
  });
  for (std::size_t slot = 0; slot < driven.tools.size(); slot++)
    readings[std::size_t(driven.tools[slot])] = driven.readings[slot];
}

Status tick_driven(const Exec& exec, World& world, DrivenTicks& driven,
                   std::span<const contact::ToolCommand> commands, std::span<contact::ToolReading> readings) {
  tick_tools(world, driven, commands, readings);
  log_ticks(world, driven);
  return step_due_frames(exec, world, driven);
}

}  // namespace turgor
