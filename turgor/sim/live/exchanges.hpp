// What passes between a haptic thread and the frames of a world while a hand feels it: a place for every body
// and every tool, each written by one side and read by the other (core/latest.hpp). World::felt names them; a
// world without them ticks its own tools.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "turgor/contact/local_contact.hpp"
#include "turgor/contact/rhombus_touch.hpp"
#include "turgor/contact/sfem_touch.hpp"
#include "turgor/sim/tools/touched_body.hpp"

namespace turgor {

/// Of a tool on a body whose forces are known once a frame.
struct LocalExchange {
  latest<contact::ToolCommand> command;  // of the haptic thread, to the frame
  latest<contact::LocalContact> plane;   // of the frame, to the haptic thread
  contact::ToolCommand before;           // the frame's: where the tool was a frame ago
  contact::LocalMemory memory;           // the frame's
};

struct Exchanges {
  std::vector<std::unique_ptr<contact::SfemExchange>> sfem;                  // as World::sfem_bodies
  std::vector<std::unique_ptr<latest<contact::RhombusTouchedNow>>> rhombus;  // as World::rhombus_bodies
  std::vector<std::unique_ptr<LocalExchange>> local;  // as World::tools; null where ticks are exact
};

/// The way of tools of one body in a frame from one time to another: from where they were to where the haptic
/// thread has them now.
void take_commands(std::span<const int> tool_indices, Exchanges& felt, double from, double to,
                   std::vector<TouchingTool>& tools);

}  // namespace turgor
