#include "turgor/sim/live/live_run.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/geometry/box.hpp"
#include "turgor/haptics/virtual_device.hpp"

namespace turgor {

namespace {

Result<int> find_tool(const World& world, const std::string& name) {
  if (world.tools.empty()) return Error{"in real time: expected a tool in the scene, found none"};
  std::string known;
  for (std::size_t t = 0; t < world.tools.size(); t++) {
    if (name.empty() || world.tools[t].name == name) return int(t);
    known += (t > 0 ? ", " : "") + world.tools[t].name;
  }
  return Error{fmt::format("in real time: expected a tool of the scene ({}), found \"{}\"", known, name)};
}

Box box_of(const TouchingTool& tool) {
  std::vector<Vec3d> positions;
  for (const PathRow& row : tool.path.rows) positions.push_back(row.position);
  for (const HandRow& row : tool.hand) positions.push_back(row.command.pose.position);
  TURGOR_CHECK(!positions.empty(), "a tool has a path");
  return box_around(positions);
}

/// Virtual device whose workspace contains the tool's path, with a margin for deflections of the hand.
std::unique_ptr<haptics::Device> virtual_hand(const TouchingTool& tool, haptics::Workspace& workspace) {
  constexpr double kMargin = 0.03;  // [m]
  const Box box = box_of(tool);
  workspace.origin = (box.low + box.high) * 0.5;
  const Vec3d half = (box.high - box.low) * 0.5 + Vec3d{kMargin, kMargin, kMargin};
  haptics::VirtualArm arm;
  arm.workspace_low = min(arm.workspace_low, -half), arm.workspace_high = max(arm.workspace_high, half);
  auto trajectory = std::make_shared<TouchingTool>();  // copy, because frames move the world's tool
  trajectory->path = tool.path, trajectory->hand = tool.hand;
  const auto hand_target = [trajectory, origin = workspace.origin](double time) {
    const contact::ToolCommand target = command_at(*trajectory, time);
    return haptics::HandTarget{.pose = {target.pose.position - origin, target.pose.axes},
                               .buttons = target.hold ? haptics::Buttons().hold : 0u};
  };
  return std::make_unique<haptics::VirtualDevice>(arm, haptics::light_grip(hand_target),
                                                  haptics::VirtualTime::kClock);
}

/// Opens the selected device. A physical device has the center of its workspace at the start of the tool's
/// path.
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

  // device
  LiveRun live;
  live.tool = world.tools[std::size_t(*tool)].name;
  haptics::Workspace workspace;
  Result<std::unique_ptr<haptics::Device>> device =
      open_hand(world.tools[std::size_t(*tool)], options, workspace);
  if (!device) return device.error();
  live.device = std::move(*device);

  // tool
  std::vector<HeldTool> held(1);
  held[0].tool = *tool;
  held[0].hand.device = live.device.get(), held[0].hand.workspace = workspace;
  LiveParams params;
  params.loop.rate = options.rate;
  // margin, because ticks continue while frames are late
  params.longest = options.longest > 0 ? options.longest : 2 * duration + 60;

  // haptic loop
  Result<std::unique_ptr<LiveTouch>> touch = LiveTouch::start(world, held, params);
  if (!touch) return touch.error();
  live.touch = std::move(*touch);
  return live;
}

}  // namespace turgor
