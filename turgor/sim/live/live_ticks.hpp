// What the haptic thread of a felt world owns: every tool of the world, whether a hand holds it or a path,
// and what each of its ticks did. Used by live_touch.cpp alone.
#pragma once

#include <atomic>
#include <span>
#include <vector>

#include "turgor/core/latest.hpp"
#include "turgor/sim/live/live_touch.hpp"

namespace turgor {

/// A body and its part of the commands.
struct TickedBody {
  BodyId id;
  std::size_t first = 0, count = 0;  // of LiveTicks::order
};

/// Of one tick, besides what a log keeps of it.
struct TickRow {
  double step = 0;  // [s]
  TickInputs inputs_used;
};

/// A tool as the haptic thread has it.
struct TickedTool {
  int index = 0;                              // into World::tools
  int hand = -1;                              // of the devices; -1: it goes on its path
  const std::atomic<bool>* is_led = nullptr;  // see HeldTool
  bool has_grip = false;
  std::vector<TickRow> rows;  // as many as samples
  bool seen = false;          // there is a tick before:
  contact::Pose pose;
  Vec3d force, torque;  // [N] [N·m]
  double work = 0;      // see FeltNow [J]
};

struct LiveTicks {
  World* world = nullptr;
  double period = kTick;            // [s]
  double began = 0;                 // the world's time when the pace was set [s]
  double step = kTick;              // of the world's time a tick [s]
  long done = 0;                    // ticks since then
  std::atomic<double> pace = 1;     // that the frame asks for
  std::atomic<long> left = -1;      // ticks that the frame allows yet; -1: all
  std::atomic<bool> rests = false;  // the frame looks at what is the haptic thread's
  std::atomic<long> turns = 0;      // of the loop, ended
  std::vector<TouchingTool> tools;  // as World::tools, whose paths, logs and grips it goes on with
  std::vector<TickedBody> bodies;
  std::vector<TickedTool> order;  // body by body, as the two below
  std::vector<contact::ToolCommand> commands;
  std::vector<contact::ToolReading> readings;
  latest<std::vector<HapticStatus>> haptic;  // as World::tools
};

/// The bodies that tools touch, and which of the tools hands hold. From here on a tick allocates nothing; it
/// keeps what it felt for `most` ticks.
void prepare_ticks(World& world, const std::vector<HeldTool>& held, std::size_t most, LiveTicks& ticks);

/// A haptics::ToolTick; its context is a LiveTicks.
void tick_all(void* context, std::span<const contact::ToolCommand> hands, double dt,
              std::span<contact::ToolReading> haptic);

}  // namespace turgor
