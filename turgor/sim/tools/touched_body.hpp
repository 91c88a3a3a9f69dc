// Tools of the scene on their way, what they feel, and what bodies of every model that tools touch have in
// common: which tools those are.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turgor/contact/forceps.hpp"
#include "turgor/contact/touch.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/sim/scene/body_id.hpp"
#include "turgor/sim/tools/hand.hpp"
#include "turgor/sim/tools/tool_path.hpp"
#include "turgor/sim/tools/touch_log.hpp"

namespace turgor {

/// Where a model could not, or would not, bear what a tool asked of it.
struct ForceLimits {
  int coarsest = 0;      // level of contact sites (contact::Site::level); 0 = every point by itself
  int dropped_most = 0;  // touched places that had no room in a tick
  int dropped_ticks = 0;
  int unsolved_ticks = 0;  // the contacts were not solved to the end
  int slips = 0;           // out of what it held
  double slipped_at = 0;   // first [s]
  int yielding_ticks = 0;  // pressed harder than the tissue bears
};

/// A tool of the scene on its way.
struct TouchingTool {
  std::string name;
  BodyId body;  // that it touches
  contact::Tool tool;
  std::optional<contact::Forceps> forceps;
  double closing_time = 0;  // of its jaws [s]
  TriMesh snapshot;         // about the tool's origin, to be drawn; jaws closed
  ToolPath path;
  std::vector<HandRow> hand;  // a recorded one, tick by tick; empty = the path says where it goes
  double grip = 0;            // after the last tick
  TouchLog samples;
  ForceLimits limits;
  std::vector<std::string> notes;  // what a person should know of its path
};

/// What its path or its hand asks of it at a time, with its jaws as they are.
contact::ToolCommand command_at(const TouchingTool& tool, double time);
/// The same in the tick that ends at a time: its jaws move on by that tick.
contact::ToolCommand next_command(TouchingTool& tool, double time);
/// In which it takes hold, with jaws or without [s].
double holding_time(const TouchingTool& tool);

/// What bodies of all models that tools touch have in common.
struct TouchedBody {
  std::string name;
  std::vector<int> tool_indices;  // into World::tools
  double usual_force = 1;         // that presses a centimetre of it in by about a centimetre [N]
};

}  // namespace turgor
