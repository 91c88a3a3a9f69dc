// An organ of the rhombus model while tools touch it.
#pragma once

#include <string>
#include <vector>

#include "turgor/models/rhombus/rhombus.hpp"
#include "turgor/sim/load_organ.hpp"
#include "turgor/sim/organ.hpp"
#include "turgor/sim/scene/rhombus_scene.hpp"

namespace turgor {

struct RhombusOrgan : TouchedOrgan {
  rhombus::Model model;
  rhombus::State state;
  std::vector<rhombus::TouchInput> inputs;  // one for each of tool_indices, as the next
  std::vector<rhombus::TouchForce> forces;
  double build_seconds = 0;
  double volume = 0;               // at rest [m³]
  double pressed_volume = 0;       // the most that was pressed in at a picture [m³]
  std::vector<double> openings;    // of the tools' jaws in the last tick [m]
  double jump = 0;                 // largest of a force per 10 µm that a tool and its jaws move [N]
  double jump_at = 0;              // [s]
  std::vector<std::string> notes;  // what was left out while reading
};

/// Without its tools; `organs` are those that its surface may be taken from. Error: names the scene's place.
Result<RhombusOrgan> load_rhombus_organ(const Exec& exec, const RhombusScene& scene,
                                        const std::vector<Organ>& organs, const BeginWork& begin);

void begin_touch(RhombusOrgan& organ);
/// Ticks from one time to another [s], in order; a tick ends at every whole multiple of kTick.
void touch_organ(RhombusOrgan& organ, std::vector<TouchingTool>& tools, double from, double to);

/// The surface as it lies now; steps the state.
OrganSurface shown_surface(const Exec& exec, RhombusOrgan& organ, const std::vector<TouchingTool>& tools,
                           double time);
/// Keeps the surface when the force on the tools is the largest so far.
void remember_deepest(const Exec& exec, RhombusOrgan& organ, const std::vector<TouchingTool>& tools,
                      double time);

/// What an organ feels of a tool: its lowest end as a ball, or what is between its jaws.
rhombus::TouchInput tip_input(const TouchingTool& tool, const contact::Pose& pose, double grip);

}  // namespace turgor
