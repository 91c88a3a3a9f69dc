// Tools of a running world with their logs, and the common base of all bodies that tools can touch.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turgor/contact/forceps.hpp"
#include "turgor/contact/texture.hpp"
#include "turgor/contact/touch.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/sim/scene/body_id.hpp"
#include "turgor/sim/tools/hand.hpp"
#include "turgor/sim/tools/tool_path.hpp"
#include "turgor/sim/tools/touch_log.hpp"

namespace turgor {

/// Events in which a model limited or dropped the contact of a tool.
struct ForceLimits {
  int coarsest = 0;      // coarsest level of contact sites (contact::Site::level); 0 = every vertex is a site
  int dropped_most = 0;  // most touched vertices without a site in a tick
  int dropped_ticks = 0;
  int unsolved_ticks = 0;           // ticks whose contact solver did not converge
  int slips = 0;                    // grasped tissue slipped out
  double slipped_at = 0;            // time of the first slip [s]
  int yielding_ticks = 0;           // ticks with a force above the tissue's limit
  int too_deep_ticks = 0;           // ticks with a press deeper than the model is valid for
  std::optional<double> passed_at;  // time at which it was first found below the present surface [s]
};

/// A tool of a running world.
struct TouchingTool {
  std::string name;
  BodyId body;  // touched body
  contact::Tool tool;
  std::optional<contact::Forceps> forceps;
  double closing_time = 0;  // of the jaws [s]
  TriMesh mesh;             // about the tool's origin, for drawing; jaws closed
  ToolPath path;
  std::vector<HandRow> hand;  // recorded hand motion; empty = the path applies
  double grip = 0;            // after the last tick
  TouchLog samples;
  ForceLimits limits;
  contact::NeedleWork needle_work = {};  // of a needle, since the start
  int punctures = 0;                     // of a needle
  double entry_force = 0;                // of a needle: largest force of the first puncture [N]
  std::vector<std::string> notes;        // notes about its path for the user
};

/// Command at a time from the path or the hand motion, with the present jaws.
contact::ToolCommand command_at(const TouchingTool& tool, double time);
/// The same for the tick of `dt` seconds that ends at a time, with the jaws after that tick.
contact::ToolCommand next_command(TouchingTool& tool, double time, double dt);
/// Duration of a grasp, with or without jaws [s].
double holding_time(const TouchingTool& tool);

/// Common data of all bodies that tools can touch.
struct TouchedBody {
  std::string name;
  std::vector<int> tool_indices;  // into World::tools
  double typical_force = 1;       // force of an indentation of about a centimeter [N]
  contact::Texture texture;       // of the surface; ticks get changed waves with the next frame
};

}  // namespace turgor
