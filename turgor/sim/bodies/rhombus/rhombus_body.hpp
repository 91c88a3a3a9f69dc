// A body of the rhombus model while tools touch it.
#pragma once

#include <string>
#include <vector>

#include "turgor/models/rhombus/rhombus.hpp"
#include "turgor/sim/bodies/sfem/load_sfem.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"
#include "turgor/sim/scene/rhombus_scene.hpp"

namespace turgor {

struct RhombusBody : TouchedBody {
  rhombus::Model model;
  rhombus::State state;
  std::vector<rhombus::TouchInput> inputs;  // one for each of tool_indices, as the next
  std::vector<rhombus::TouchForce> forces;
  std::vector<int>
      mesh_vertex;  // of each vertex, in the mesh of the body whose surface it is; empty = its own
  double build_seconds = 0;
  double volume = 0;               // at rest [m³]
  double pressed_volume = 0;       // the most that was pressed in at a picture [m³]
  std::vector<double> openings;    // of the tools' jaws in the last tick [m]
  double jump = 0;                 // largest of a force per 10 µm that a tool and its jaws move [N]
  double jump_at = 0;              // [s]
  std::vector<std::string> notes;  // what was left out while reading
};

/// Without its tools; `bodies` are those that its surface may be taken from. Error: names the scene's place.
Result<RhombusBody> load_rhombus(const Exec& exec, const RhombusScene& scene,
                                 const std::vector<SfemBody>& bodies, const BeginWork& begin);

/// The surface that tools touch.
RestSurface rest_surface(const RhombusBody& body);
void begin_touch(RhombusBody& body);
/// Ticks from one time to another [s], in order; a tick ends at every whole multiple of kTick.
void touch_body(RhombusBody& body, std::vector<TouchingTool>& tools, double from, double to);

/// The surface as it lies now; steps the state.
ShownSurface shown_surface(const Exec& exec, RhombusBody& body, const std::vector<TouchingTool>& tools,
                           double time);
/// Keeps the surface when the force on the tools is the largest so far.
void remember_deepest(const Exec& exec, RhombusBody& body, const std::vector<TouchingTool>& tools,
                      double time);

/// What a body feels of a tool: its lowest end as a ball, or what is between its jaws.
rhombus::TouchInput tip_input(const TouchingTool& tool, const contact::Pose& pose, double grip);

}  // namespace turgor
