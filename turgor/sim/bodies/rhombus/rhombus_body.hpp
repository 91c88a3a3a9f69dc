// A body of the rhombus model while tools touch it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "turgor/contact/rhombus_touch.hpp"
#include "turgor/core/boxed.hpp"
#include "turgor/models/rhombus/rhombus.hpp"
#include "turgor/sim/bodies/cloth/cloth_load.hpp"
#include "turgor/sim/frame.hpp"
#include "turgor/sim/live/tick_inputs.hpp"
#include "turgor/sim/loading.hpp"
#include "turgor/sim/scene/rhombus_scene.hpp"
#include "turgor/sim/snapshot.hpp"
#include "turgor/sim/tools/press_path.hpp"
#include "turgor/sim/tools/touched_body.hpp"

namespace turgor {

struct World;

struct RhombusBody : TouchedBody {
  rhombus::Model model;
  contact::RhombusTouch touch;                       // who ticks owns this
  boxed<latest<contact::RhombusTouchedNow>> haptic;  // while a haptic thread ticks: what it leaves
  contact::RhombusTouchedNow now;  // what it left for the frame; one for each of tool_indices
  rhombus::State state;            // of the frame: the surface as it was shown last
  ClothLoad cloth;                 // what lies on it
  std::vector<int> mesh_vertex;    // in the mesh of the body whose surface it is; empty = its own
  double build_seconds = 0;
  double volume = 0;               // at rest [m³]
  double pressed_volume = 0;       // the most that was pressed in after a frame [m³]
  std::vector<double> openings;    // of the tools' jaws in the last tick [m]
  double jump = 0;                 // largest of a force per 10 µm that a tool and its jaws move [N]
  double jump_at = 0;              // [s]
  std::vector<std::string> notes;  // what was left out while reading
};

/// Without its tools; its surface may be that of a body that the world has. Error: names the scene's place.
Result<RhombusBody> load_body(const Loading& loading, const RhombusScene& scene, const World& world);
inline const std::vector<std::string>& notes(const RhombusBody& body) { return body.notes; }

/// The surface that tools touch.
RestSurface rest_surface(const RhombusBody& body);
inline void make_rest_surface(RhombusBody&) {}  // it is there
/// Error: more tools than the model takes.
Status begin_body(const Exec& exec, RhombusBody& body, const RhombusScene& scene, const World& world);

/// The ticks of a frame, and where that leaves the surface.
void step_body(const Exec& exec, RhombusBody& body, World& world, const FrameInput& input,
               FrameReport& report);
/// Feels what cloth does to it, from the next frame on.
void press_body(const Exec& exec, RhombusBody& body, const ClothPush& push, double dt);
std::uint64_t state_hash(const RhombusBody& body, std::uint64_t seed);
/// Ticks from one time to another [s], in order; a tick ends at every whole multiple of kTick. Ends with
/// take_touched, as who ticks and who makes frames are one here.
void touch_body(RhombusBody& body, std::vector<TouchingTool>& tools, double from, double to);
/// Keeps the last tick of tool `t` of its tool_indices.
void log_tick(RhombusBody& body, std::size_t t, const ForceSample& sample, TouchingTool& tool);
/// The frame takes what ticks left: body.now was just filled.
void take_touched(RhombusBody& body);

/// For a haptic thread, and for who does again what it did: see sim/live/exchanges.hpp. A tick needs nothing
/// of the frame.
void begin_haptics(RhombusBody& body, const std::vector<TouchingTool>& tools);
void tick_haptics(RhombusBody& body, std::span<const contact::ToolCommand> commands, double dt,
                  std::span<contact::ToolReading> readings);
inline TickInputs tick_inputs(const RhombusBody&, std::size_t) { return {}; }
inline FrameInputs frame_inputs(const RhombusBody& body, std::size_t) {
  return {std::int32_t(body.now.ticks), 0};
}
inline void end_haptics(RhombusBody& body) { body.haptic.reset(); }
inline void keep_frame(RhombusBody&) {}
inline void give_frame(RhombusBody&, std::size_t, TickInputs) {}
inline void expect_patch(RhombusBody&, bool) {}
inline void set_friction(RhombusBody&, std::size_t, double) {}  // chains know none

/// Tool `t` of its tool_indices.
ToolNow tool_now(const RhombusBody& body, std::size_t t, const World& world);
inline Look look_of(const RhombusBody&) { return Look::kFlesh; }
void show(const Exec& exec, const RhombusBody& body, BodySnapshot& out);

}  // namespace turgor
