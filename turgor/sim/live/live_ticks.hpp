// State of the haptic thread of a running world: all tools, whether a device or a path moves them, and the
// record of their ticks. Used by live_touch.cpp only.
#pragma once

#include <atomic>
#include <span>
#include <string>
#include <vector>

#include "turgor/core/latest.hpp"
#include "turgor/sim/live/live_touch.hpp"

namespace turgor {

/// A touched body and the range of its tools.
struct TickedBody {
  BodyId id;
  std::size_t first = 0, count = 0;  // range in LiveTicks::order
};

/// A tool in the haptic thread.
struct TickedTool {
  int index = 0;                                 // index into World::tools
  int hand = -1;                                 // index of the device that holds it; -1: moved by its path
  const std::atomic<bool>* is_driven = nullptr;  // see HeldTool::is_driven
  bool has_grip = false, keeps_force = false;    // see HeldTool::keeps_force
  DiskLog<HapticTick> recorded;                  // one per logged sample
  bool has_previous =
      false;  // true after the first tick; `pose`, `force` and `torque` are then those of the previous tick
  contact::Pose pose;
  Vec3d force, torque;                 // [N] [N·m]
  double work = 0;                     // net work of the hand on the body [J]
  contact::NeedleReading needle = {};  // of the newest tick, if it is a needle
};

struct LiveTicks {
  World* world = nullptr;
  double period = kTick;                // tick period of the loop [s]
  double start_time = 0;                // simulated time at the latest change of pace [s]
  double step = kTick;                  // simulated time per tick [s]
  long done = 0;                        // number of periods since start_time, also of those without a tick
  double unspent = 0;                   // wall-clock time that `done` has not counted yet [s]
  double path_time = 0;                 // of tools on paths; below the simulated time after missed ticks [s]
  std::atomic<double> pace = 1;         // simulated seconds per second, requested by the frame thread
  std::atomic<long> allowed = -1;       // number of ticks that may still run; -1: unlimited
  std::atomic<bool> is_paused = false;  // true while the frame thread reads data of the haptic thread
  std::atomic<long> loop_count = 0;     // number of finished iterations of the haptic loop
  std::vector<TouchingTool>
      tools;  // copy of World::tools with paths, logs and grips; the frame thread uses the original
  std::vector<TickedBody> bodies;
  std::vector<TickedTool> order;  // tools body by body; the two arrays below have the same order
  std::vector<contact::ToolCommand> commands;
  std::vector<contact::ToolReading> readings;
  latest<std::vector<HapticStatus>> haptic;  // indexed as World::tools
  std::vector<std::string> notes;            // threads that the system refused
};

/// Largest number of recorded ticks, and of those in memory.
struct RecordLimits {
  std::size_t most = 0, in_memory = 0;
};

/// Prepares the ticks of all touched bodies and assigns tools to devices. Later ticks do not allocate.
void prepare_ticks(World& world, const std::vector<HeldTool>& held, RecordLimits limits, LiveTicks& ticks);
/// Moves older recorded ticks to disk; frame thread.
void save_ticks(LiveTicks& ticks);

/// haptics::ToolTick; `context` points to a LiveTicks.
void tick_all(void* context, std::span<const contact::ToolCommand> hands, double dt,
              std::span<contact::ToolReading> haptic);

}  // namespace turgor
