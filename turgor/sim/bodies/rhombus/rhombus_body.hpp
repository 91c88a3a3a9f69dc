// Body of the rhombus model in a running world.
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

/// Exchange with a haptic thread, and a queue of a replay (sim/live/exchanges.hpp).
struct RhombusHaptics {
  latest<contact::RhombusTissue> tissue;          // from the frame
  latest<contact::RhombusTouchSnapshot> touched;  // from the haptic thread
  ReplayQueue<contact::RhombusTissue> changes;
};

struct RhombusBody : TouchedBody {
  rhombus::Model model;
  contact::RhombusTouch touch;   // owned by the ticking thread
  boxed<RhombusHaptics> haptic;  // with a haptic thread
  double stiffness_scale = 1;    // relative to the model; owned by the frame thread, as is the next
  Prony viscosity;
  contact::RhombusTissue published;   // parameters that the haptic thread was sent last
  contact::RhombusTouchSnapshot now;  // latest touch state; one for each of tool_indices
  rhombus::State state;               // of the frame thread: the surface of the latest snapshot
  ClothLoad cloth;                    // load of cloth
  std::vector<int> mesh_vertex;       // index in the mesh of the body that owns the surface; empty = own mesh
  double build_seconds = 0;
  double volume = 0;               // at rest [m³]
  double pressed_volume = 0;       // largest indented volume at the end of a frame [m³]
  std::vector<double> openings;    // of the tools' jaws in the last tick [m]
  double jump = 0;                 // largest force jump per 10 µm of tool or jaw displacement [N]
  double jump_at = 0;              // [s]
  std::vector<std::string> notes;  // notes of readers
};

/// Body without tools; its surface may be that of an sfem body of `world`. Error: has the source location.
Result<RhombusBody> load_body(const Loading& loading, const RhombusScene& scene, const World& world);
inline const std::vector<std::string>& notes(const RhombusBody& body) { return body.notes; }

/// Surface for contact.
RestSurface rest_surface(const RhombusBody& body);
inline void make_rest_surface(const Exec&, RhombusBody&) {}  // exists already
/// Error: more tools than the model supports.
Status begin_body(const Exec& exec, RhombusBody& body, const RhombusScene& scene, const World& world);

/// Runs the ticks of a frame, then updates the surface.
void step_body(const Exec& exec, RhombusBody& body, World& world, const FrameInput& input,
               FrameReport& report);
/// Present displacement of the vertices without that by these forces of other bodies [m].
std::vector<Vec3d> displacement_without(const Exec& exec, const RhombusBody& body,
                                        std::span<const contact::VertexForce> forces);
/// Applies forces of cloth and of other bodies, from the next frame on.
void press_body(const Exec& exec, RhombusBody& body, const ClothForces& push, double dt);
std::uint64_t state_hash(const RhombusBody& body, std::uint64_t seed);
/// Runs the ticks between two times [s]; a tick ends at every multiple of kTick. Includes
/// read_touch_snapshot, since ticks and frames share a thread here.
void touch_body(RhombusBody& body, std::vector<TouchingTool>& tools, double from, double to);
/// Logs the last tick of tool `t` of tool_indices.
void log_tick(RhombusBody& body, std::size_t t, const ForceSample& sample, TouchingTool& tool);
/// Processes the touch state, after body.now was filled.
void read_touch_snapshot(RhombusBody& body);

/// Functions for a haptic thread and for replays: see sim/live/exchanges.hpp. The only input that ticks need
/// from frames is a changed stiffness, viscosity or texture.
void begin_haptics(RhombusBody& body, const std::vector<TouchingTool>& tools);
void tick_haptics(RhombusBody& body, std::span<const contact::ToolCommand> commands, double dt,
                  std::span<contact::ToolReading> readings);
inline TickInputs tick_inputs(const RhombusBody& body, std::size_t) {
  return {std::int32_t(body.touch.tissue.number), 0};
}
inline FrameInputs frame_inputs(const RhombusBody& body, std::size_t) {
  return {std::int32_t(body.now.ticks), 0};
}
inline void end_haptics(RhombusBody& body) { body.haptic.reset(); }
inline Status begin_solutions(RhombusBody&, bool) { return Done{}; }
void queue_frame_output(RhombusBody& body);
void replay_frame_output(RhombusBody& body, std::size_t t, TickInputs inputs_used);
/// Sends changed parameters to the ticks, once per frame.
void publish_tissue(RhombusBody& body);
inline void expect_patch(RhombusBody&, bool) {}
inline void set_friction(RhombusBody&, std::size_t, double) {}  // chains have no friction

/// State of tool `t` of tool_indices.
ToolNow tool_now(const RhombusBody& body, std::size_t t, const World& world);
inline Look look_of(const RhombusBody&) { return Look::kFlesh; }
void show(const Exec& exec, const RhombusBody& body, BodySnapshot& out);

}  // namespace turgor
