#include "turgor/sim/live/live_run.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/geometry/box.hpp"
#include "turgor/haptics/device_presets.hpp"
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

/// The smaller one of two limits, of which 0 is unknown.
double smaller_known(double a, double b) { return a > 0 && b > 0 ? std::min(a, b) : std::max(a, b); }

/// Limits for the hand that holds a device. The virtual coupling renders at most the device's stiffness; its
/// damping stays as far below the critical one, 2 √(K m), as that of the default coupling.
void limit_hand(double force, double stiffness, double damping, haptics::Hand& hand) {
  TURGOR_CHECK(force > 0 && stiffness > 0, "a device has a largest force and a stiffness");
  hand.safety.force = force;
  haptics::Coupling coupling;
  coupling.damping *= std::sqrt(stiffness / coupling.stiffness);
  if (damping > 0) coupling.damping = std::min(coupling.damping, damping);
  coupling.stiffness = stiffness;
  hand.coupling = coupling;
}

/// Limits of the device that the scene names, for a simulated hand.
void apply_limits(const haptics::DevicePreset& device, haptics::VirtualArm& arm, haptics::Hand& hand) {
  limit_hand(device.force, device.stiffness, device.damping, hand);
  arm.force = device.force;
  if (device.radius > 0) {
    arm.workspace_high = {device.radius, device.radius, device.radius};
    arm.workspace_low = -arm.workspace_high;
  }
}

/// The same for a physical device: of both, the smaller limits apply. Returns a note if they differ. A replay
/// renders no force and has no limits.
std::string apply_limits(const haptics::DevicePreset& named, const haptics::DeviceSpec& device,
                         haptics::Hand& hand) {
  if (!std::isfinite(device.force)) return {};
  limit_hand(smaller_known(named.force, device.force), smaller_known(named.stiffness, device.stiffness),
             smaller_known(named.damping, device.damping), hand);
  if (device.force == named.force && (device.stiffness == named.stiffness || device.stiffness == 0))
    return {};
  return fmt::format(
      "the scene names a {} ({:g} N, {:g} N/m), and the device is a {} ({:g} N, {:g} N/m): the smaller "
      "limits apply",
      named.title, named.force, named.stiffness, device.name, device.force, device.stiffness);
}

/// Virtual device whose workspace contains the tool's path, with a margin for deflections of the hand, or
/// with the limits of a device.
std::unique_ptr<haptics::Device> virtual_hand(const TouchingTool& tool, const haptics::DevicePreset* limits,
                                              haptics::Hand& hand) {
  haptics::Workspace& workspace = hand.workspace;
  constexpr double kMargin = 0.03;  // [m]
  const Box box = box_of(tool);
  workspace.origin = (box.low + box.high) * 0.5;
  const Vec3d half = (box.high - box.low) * 0.5 + Vec3d{kMargin, kMargin, kMargin};
  haptics::VirtualArm arm;
  arm.workspace_low = min(arm.workspace_low, -half), arm.workspace_high = max(arm.workspace_high, half);
  if (limits) apply_limits(*limits, arm, hand);
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

/// Opens a physical device. The center of its workspace is at the start of the tool's path. The tool points
/// where the grip points. Without an orientation it keeps the axes with which its path starts.
Status open_driver(const TouchingTool& tool, const LiveOptions& options, haptics::Hand& hand, LiveRun& live) {
  Result<std::unique_ptr<haptics::Device>> device = haptics::open_device(options.device, options.driver);
  if (!device) return device.error();
  live.device = std::move(*device);
  const haptics::DeviceSpec& spec = live.device->spec();
  const contact::Pose start = command_at(tool, 0).pose;
  hand.workspace.origin = start.position;
  hand.workspace.tool_axes = spec.has_orientation ? haptics::kToolInGrip : start.axes;
  if (const haptics::DevicePreset* named = haptics::find_device_preset(options.limits))
    if (const std::string note = apply_limits(*named, spec, hand); !note.empty()) live.notes.push_back(note);
  return Done{};
}

/// Opens the selected device.
Status open_hand(const TouchingTool& tool, const LiveOptions& options, haptics::Hand& hand, LiveRun& live) {
  if (options.device != "virtual") return open_driver(tool, options, hand, live);
  live.device = virtual_hand(tool, haptics::find_device_preset(options.limits), hand);
  return live.device->open();
}

}  // namespace

Result<LiveRun> start_live(World& world, const LiveOptions& options, double duration) {
  const Result<int> tool = find_tool(world, options.tool);
  if (!tool) return tool.error();

  // device
  LiveRun live;
  live.tool = world.tools[std::size_t(*tool)].name;
  haptics::Hand hand;
  if (const Status opened = open_hand(world.tools[std::size_t(*tool)], options, hand, live); !opened)
    return opened.error();

  // tool
  std::vector<HeldTool> held(1);
  held[0].tool = *tool;
  held[0].hand = hand, held[0].hand.device = live.device.get();
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
