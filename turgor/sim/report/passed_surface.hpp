// Warning about a tool that passed through its body, where no contact held it back: within one step of its
// path, between the samples of the surface, or out on the other side.
#pragma once

#include <optional>
#include <string>

#include "turgor/sim/world.hpp"

namespace turgor {

/// Passage of a tool.
struct SurfacePassage {
  double time = 0;    // end of the step in which it was found [s]
  double moved = 0;   // displacement of the tool in this step; 0 = it passed without a jump [m]
  double within = 0;  // length of this step [s]
};
/// First passage of a tool of a scene's path; empty if there was none.
std::optional<SurfacePassage> surface_passage(const World& world, const TouchingTool& tool);

/// A sentence about the passage; empty without one.
std::string passed_surface_note(const World& world, const TouchingTool& tool);

}  // namespace turgor
