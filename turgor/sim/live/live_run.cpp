#include "turgor/sim/live/live_run.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "turgor/geometry/box.hpp"
#include "turgor/haptics/virtual_device.hpp"

namespace turgor {

namespace {

Result<int> find_tool(const World& world, const std::string& name) {
  if (world.tools.empty())
    return Error{"in real time: expected a tool in the scene that a hand can hold, found none"};
  std::string known;
  for (std::size_t t = 0; t < world.tools.size(); t++) {
    if (name.empty() || world.tools[t].name == name) return int(t);
    known += (t > 0 ? ", " : "") + world.tools[t].name;
  }
  return Error{fmt::format("in real time: expected a tool of the scene ({}), found \"{}\"", known, name)};
}

Box box_of(const TouchingTool& tool) {
  std::vector<Vec3d> places;
  for (const PathRow& row : tool.path.rows) places.push_back(row.position);
  for (const HandRow& row : tool.hand) places.push_back(row.command.pose.position);
  return box_around(places);
}

/// Its workspace lies around the tool's path, with room to be pushed aside.
std::unique_ptr<haptics::Device> virtual_hand(const TouchingTool& tool, haptics::Workspace& workspace) {
  constexpr double kRoom = 0.03;  // [m]
  const Box box = box_of(tool);
  workspace.origin = (box.low + box.high) * 0.5;
  const Vec3d half = (box.high - box.low) * 0.5 + Vec3d{kRoom, kRoom, kRoom};
  haptics::VirtualArm arm;
  arm.workspace_low = min(arm.workspace_low, -half), arm.workspace_high = max(arm.workspace_high, half);
  auto way = std::make_shared<TouchingTool>();  // the hand's own: the world's goes on with the frames
  way->path = tool.path, way->hand = tool.hand;
  const auto target = [way, origin = workspace.origin](double time) {
    const contact::ToolCommand wanted = command_at(*way, time);
    return haptics::HandTarget{.pose = {wanted.pose.position - origin, wanted.pose.axes},
                               .buttons = wanted.hold ? haptics::Buttons().hold : 0u};
  };
  return std::make_unique<haptics::VirtualDevice>(arm, haptics::light_hand(target),
                                                  haptics::VirtualTime::kClock);
}

/// A real one: the middle of its workspace is where the tool's path begins.
Result<std::unique_ptr<haptics::Device>> open_hand(const TouchingTool& tool, const LiveOptions& options,
                                                   haptics::Workspace& workspace) {
  if (options.device != "virtual") {
    workspace.origin = command_at(tool, 0).pose.position;
    return haptics::open_device(options.device, options.driver);
  }
  std::unique_ptr<haptics::Device> device = virtual_hand(tool, workspace);
  if (const Status status = device->open(); !status) return status.error();
  return device;
}

}  // namespace

Result<LiveRun> start_live(World& world, const LiveOptions& options, double duration) {
  const Result<int> tool = find_tool(world, options.tool);
  if (!tool) return tool.error();
  LiveRun live;
  live.tool = world.tools[std::size_t(*tool)].name;
  haptics::Workspace workspace;
  Result<std::unique_ptr<haptics::Device>> device =
      open_hand(world.tools[std::size_t(*tool)], options, workspace);
  if (!device) return device.error();
  live.device = std::move(*device);
  std::vector<HeldTool> held(1);
  held[0].tool = *tool;
  held[0].hand.device = live.device.get(), held[0].hand.workspace = workspace;
  LiveParams params;
  params.loop.rate = options.rate;
  // Frames may come late, and ticks go on meanwhile.
  params.longest = options.longest > 0 ? options.longest : 2 * duration + 60;
  Result<std::unique_ptr<LiveTouch>> touch = LiveTouch::start(world, held, params);
  if (!touch) return touch.error();
  live.touch = std::move(*touch);
  return live;
}

}  // namespace turgor
