// World whose tools are driven tick by tick by the caller, without devices and without a clock. Ticks and
// frames alternate on one thread. A frame runs once its simulated time has passed. A new patch is used from
// the next frame on. The same commands give the same bits on every machine, for any number of ticks per call.
//
//   begin_driven   starts the ticks: bodies get `haptic` (exchanges.hpp)
//   tick_driven    one tick, and the frames that are due
//   tick_tools     one tick only, for a haptic thread that runs beside a thread calling step()
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "turgor/sim/world.hpp"

namespace turgor {

/// State of the ticks. A copy of the world needs a copy of this state.
struct DrivenTicks {
  double began = 0;        // simulated time at begin_driven [s]
  long done = 0;           // number of ticks since begin_driven
  std::vector<int> tools;  // indices into World::tools, body by body; the arrays below have the same order
  std::vector<contact::ToolCommand> commands;
  std::vector<contact::ToolReading> readings;
  std::vector<double> grip;  // closure of the jaws: 0 open, 1 closed
  // of World::tools: path, hand motion and grip before the first tick. Frames replace the hand motion of
  // tools on lattices, cloth and rigid bodies by that of the ticks.
  std::shared_ptr<const std::vector<TouchingTool>> paths;
};

/// Starts the ticks with all tools at their present positions.
DrivenTicks begin_driven(World& world);
void end_driven(World& world);

/// Simulated time after the last tick [s].
inline double time_of(const DrivenTicks& driven) { return driven.began + double(driven.done) * kTick; }

/// Command of one of World::tools from its own path or hand motion. It reads no data of frames.
contact::ToolCommand path_command(const DrivenTicks& driven, std::size_t tool, double time);

/// One tick with a command and a reading for each of World::tools. The grip of a command is ignored: `hold`
/// opens and closes the jaws. Writes no logs, does not allocate or wait, and reads data of frames through
/// latest<> only.
void tick_tools(World& world, DrivenTicks& driven, std::span<const contact::ToolCommand> commands,
                std::span<contact::ToolReading> readings);

/// One tick with logs, then the frames that are due. Error: a blade left the skin, or a step was not finite.
Status tick_driven(const Exec& exec, World& world, DrivenTicks& driven,
                   std::span<const contact::ToolCommand> commands, std::span<contact::ToolReading> readings);

}  // namespace turgor
