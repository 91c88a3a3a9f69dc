// The hand of a run in real time: which device, which tool, and where the device lies in the world.
#pragma once

#include <memory>
#include <string>

#include "turgor/haptics/drivers/devices.hpp"
#include "turgor/sim/live/live_touch.hpp"
#include "turgor/sim/report/report.hpp"

namespace turgor {

/// `device` = "virtual": an arm that is computed, held by a hand that wants to go the tool's path.
struct LiveOptions {
  std::string device = "virtual";
  haptics::DeviceOptions driver;  // of real ones
  std::string tool;               // by name; empty: the first one
  double rate = 1000;             // of the haptic loop [Hz]
  double longest = 0;  // so much of what tools feel is kept; 0: twice the duration and a minute [s]
};

/// A run in real time on its way. The device outlives the loop.
struct LiveRun {
  std::unique_ptr<haptics::Device> device;
  std::unique_ptr<LiveTouch> touch;
  std::string tool;
};

/// Opens the device and begins to tick; `duration` of the scene [s]. Error: there is no such tool or device,
/// or what the device's open says.
Result<LiveRun> start_live(World& world, const LiveOptions& options, double duration);

/// How the loop kept its time and what its safety did: report.json's "haptics".
Json haptics_report(LiveRun& live);
/// What a person should know of it: sentences.
std::vector<std::string> haptics_warnings(LiveRun& live);

}  // namespace turgor
