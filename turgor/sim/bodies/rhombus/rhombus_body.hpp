// A body of the rhombus model while tools touch it.
#pragma once

#include <string>
#include <vector>

#include "turgor/contact/rhombus_touch.hpp"
#include "turgor/models/rhombus/rhombus.hpp"
#include "turgor/sim/bodies/sfem/load_sfem.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"
#include "turgor/sim/scene/rhombus_scene.hpp"

namespace turgor {

struct RhombusBody : TouchedBody {
  rhombus::Model model;
  contact::RhombusTouch touch;     // who ticks owns this
  contact::RhombusTouchedNow now;  // what it left for the frame; one for each of tool_indices
  rhombus::State state;            // of the frame: the surface as it was shown last
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
void begin_touch(RhombusBody& body, const std::vector<TouchingTool>& tools);
/// Ticks from one time to another [s], in order; a tick ends at every whole multiple of kTick. Ends with
/// take_touched, as who ticks and who makes frames are one here.
void touch_body(RhombusBody& body, std::vector<TouchingTool>& tools, double from, double to);
/// The frame takes what ticks left: body.now was just filled.
void take_touched(RhombusBody& body);

/// The surface as it lies now; steps the state.
ShownSurface shown_surface(const Exec& exec, RhombusBody& body, double time);
/// Keeps the surface when the force on the tools is the largest so far.
void remember_deepest(const Exec& exec, RhombusBody& body, double time);

}  // namespace turgor
