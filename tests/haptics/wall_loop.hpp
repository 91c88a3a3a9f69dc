// A wall of tissue under the hands of a haptic loop, and the conditions that tests wait for.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <span>
#include <thread>

#include "turgor/haptics/loop.hpp"
#include "turgor/haptics/real_time.hpp"
#include "turgor/haptics/virtual_device.hpp"

namespace turgor::haptics {

/// Tests request no real-time priority; they must hold without it.
constexpr LoopParams kPlain{.rate = 1000, .priority = 0, .lock_memory = false};

inline SafetyParams short_ramp() { return {.force = 12, .ramp = 0.005}; }

inline bool wait_for(const std::function<bool()>& done, double seconds = 60) {
  const double end = steady_seconds() + seconds;
  while (!done() && steady_seconds() < end) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return done();
}

/// A wall at z = 0 with 500 N/m, for every tool.
struct Wall {
  std::atomic<int> ticks = 0;
  std::atomic<std::size_t> tools = 0;
  static void tick(void* context, std::span<const contact::ToolCommand> commands, double,
                   std::span<contact::ToolReading> readings) {
    Wall& wall = *static_cast<Wall*>(context);
    wall.tools = commands.size();
    for (std::size_t i = 0; i < commands.size(); i++)
      readings[i].force.z = 500 * std::max(0.0, -commands[i].pose.position.z);
    wall.ticks++;
  }
};

/// Target that moves from 5 mm above the wall to 5 mm below it within 0.2 s.
inline HandTarget press(double time) {
  return {.pose = {.position = {0, 0, 0.005 - 0.01 * std::min(1.0, 5 * time)}, .axes = {}}};
}

}  // namespace turgor::haptics
