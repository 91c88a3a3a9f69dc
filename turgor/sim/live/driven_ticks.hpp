// A world whose tools are led tick by tick by whoever calls, without devices and without a clock. Ticks and
// frames come in turn on one thread, a frame when its time is over, and a patch that is built is there at the
// next frame: the same commands give the same bits on any machine, a tick at a time or a thousand.
//
//   begin_led   bodies have `felt` (exchanges.hpp) from here on
//   tick_led    a tick, and the frame if it is due
//   tick_tools  a tick alone, for a haptic thread beside a thread that makes frames by step()
#pragma once

#include <span>
#include <vector>

#include "turgor/sim/world.hpp"

namespace turgor {

/// Plain, so that it is copied with its world.
struct LedTicks {
  double began = 0;        // the world's time [s]
  long done = 0;           // ticks since then
  std::vector<int> tools;  // body by body: index into World::tools, as the three below
  std::vector<contact::ToolCommand> commands;
  std::vector<contact::ToolReading> readings;
  std::vector<double> grip;  // of their jaws
};

/// Tools are where they are now. Nobody leads them yet.
LedTicks begin_led(World& world);
void end_led(World& world);

/// Where the ticks are [s].
inline double time_of(const LedTicks& led) { return led.began + double(led.done) * kTick; }

/// One tick: a command and a reading for each of World::tools, whose grip follows from `hold`. Writes no
/// logs. Neither allocates nor waits; what frames change of the world it reads through latest<> alone.
void tick_tools(World& world, LedTicks& led, std::span<const contact::ToolCommand> commands,
                std::span<contact::ToolReading> readings);

/// The same with logs, and with the frame that ends then. Error: a blade found no skin any more, or the
/// numbers of a step were not finite.
Status tick_led(const Exec& exec, World& world, LedTicks& led, std::span<const contact::ToolCommand> commands,
                std::span<contact::ToolReading> readings);

}  // namespace turgor
