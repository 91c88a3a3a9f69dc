// Run in real time with one device that holds one tool, and its report.
#pragma once

#include <memory>
#include <string>

#include "turgor/haptics/drivers/devices.hpp"
#include "turgor/sim/live/live_touch.hpp"
#include "turgor/sim/report/report.hpp"

namespace turgor {

/// Device and tool of a run. `device` = "virtual": a simulated arm, held by a simulated hand that follows the
/// tool's path.
struct LiveOptions {
  std::string device = "virtual";
  haptics::DeviceOptions driver;  // options of physical devices
  std::string tool;               // name of the tool in the device; empty: the first tool
  std::string limits;             // preset of haptics/device_presets.hpp that limits the device; empty: none
  double rate = 1000;             // rate of the haptic loop; see haptics::loop_rate [Hz]
  double longest = 0;  // limit of the recorded time; 0: twice the scene's duration plus one minute [s]
};

/// State of a run in real time. `device` must outlive `touch`.
struct LiveRun {
  std::unique_ptr<haptics::Device> device;
  std::unique_ptr<LiveTouch> touch;
  std::string tool;
  std::vector<std::string> notes;  // on the limits of the device
};

/// Opens the device and starts the ticks. `duration` is that of the scene [s]. Error: unknown tool or device,
/// or an error of Device::open or LiveTouch::start.
Result<LiveRun> start_live(World& world, const LiveOptions& options, double duration);

/// Timing of the loop and actions of its safety layer: "haptics" in report.json.
Json haptics_report(LiveRun& live);
/// Warnings of the haptic loop.
std::vector<std::string> haptics_warnings(LiveRun& live);

}  // namespace turgor
