#include "turgor/sim/tools/touched_body.hpp"

#include "turgor/core/assert.hpp"

namespace turgor {

contact::ToolCommand command_at(const TouchingTool& tool, double time) {
  if (!tool.hand.empty()) return hand_at(tool.hand, time).command;
  const PathRow row = path_at(tool.path, time);
  return {.pose = {row.position, axes_of(row.orientation)}, .grip = tool.grip, .hold = row.hold};
}

contact::ToolCommand next_command(TouchingTool& tool, double time, double dt) {
  contact::ToolCommand command = command_at(tool, time);
  if (tool.hand.empty()) command.grip = contact::next_grip(tool.grip, command.hold, holding_time(tool), dt);
  tool.grip = command.grip;
  TURGOR_CHECK(command.grip >= 0 && command.grip <= 1, "a grip is from 0, open, to 1, closed");
  return command;
}

double holding_time(const TouchingTool& tool) {
  TURGOR_CHECK(!tool.forceps || tool.closing_time > 0, "jaws close in a positive time");
  constexpr double kWithoutJaws = 0.05;
  return tool.forceps ? tool.closing_time : kWithoutJaws;
}

}  // namespace turgor
