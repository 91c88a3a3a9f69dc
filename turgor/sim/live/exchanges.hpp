// Exchange between the haptic thread and the frames of a body whose contact forces are computed once per
// frame (lattice, cloth). For each tool the haptic thread sends a command, and the frame sends a local
// contact plane (contact/local_contact.hpp). Bodies of sfem and rhombus have their own exchange. Every body
// that tools touch has overloads of the same names:
//
//   begin_haptics        before the haptic thread starts: allocates `haptic`; frames stop ticking tools
//   tick_haptics         haptic thread: one command and one reading per tool
//   log_tick             haptic thread: logs the sample of a tool
//   tick_inputs          haptic thread: numbers of the frame data that the tick used
//   frame_inputs         frame: numbers of the ticks and patches that the frame used
//   end_haptics          after the haptic thread has ended
//   begin_solutions      after begin_haptics: a nonlinear patch is solved on a thread of its own
//
// Three more make ticks without a clock reproducible. expect_patch decides whether the next frame takes a new
// patch. The replay (haptic_replay.hpp) calls queue_frame_output after a frame and replay_frame_output before
// a tick.
#pragma once

#include <span>
#include <vector>

#include "turgor/contact/local_contact.hpp"
#include "turgor/core/result.hpp"
#include "turgor/sim/live/tick_inputs.hpp"
#include "turgor/sim/tools/touched_body.hpp"

namespace turgor {

struct NumberedCommand {
  contact::ToolCommand command;
  std::int32_t number = 0;  // number of ticks so far
  std::int32_t teleports =
      0;  // number of teleports so far: displacements in one tick that a hand cannot make
  contact::Pose teleported_to;    // pose after the latest teleport
  contact::TextureState texture;  // after the tick before
};

/// Exchange of one tool.
struct LocalExchange {
  latest<NumberedCommand> command;      // from the haptic thread to the frame
  latest<contact::LocalContact> plane;  // from the frame to the haptic thread

  // owned by the frame
  contact::ToolCommand before;  // command at the end of the previous frame
  std::int32_t ticks = 0;       // NumberedCommand::number of `before`
  std::int32_t teleports = 0;   // NumberedCommand::teleports of `before`
  bool was_teleported = false;  // true if the tool was teleported since the previous frame; its motion then
                                // starts at the teleport's pose
  contact::LocalContactHistory history;
  long plane_count = 0;  // number of planes published so far
  ReplayQueue<contact::LocalContact> replay_queue;

  // owned by the haptic thread
  contact::LocalTouch touch;
  NumberedCommand latest_tick;
  double age = 0;  // time since the newest plane arrived [s]
};

/// Body whose contact forces are computed once per frame. While a haptic thread runs, `haptic` has one entry
/// for each of tool_indices; otherwise it is empty.
struct FrameTouchedBody : TouchedBody {
  std::vector<LocalExchange> haptic;
  std::vector<contact::TextureState> textures;  // latest of each tool; empty: no haptic thread has run
};

void begin_haptics(FrameTouchedBody& body, const std::vector<TouchingTool>& tools);
void tick_haptics(FrameTouchedBody& body, std::span<const contact::ToolCommand> commands, double dt,
                  std::span<contact::ToolReading> readings);
void log_tick(const FrameTouchedBody& body, std::size_t t, const ForceSample& sample, TouchingTool& tool);
inline TickInputs tick_inputs(const FrameTouchedBody& body, std::size_t t) {
  return {std::int32_t(body.haptic[t].touch.contact.number), 0};
}
inline FrameInputs frame_inputs(const FrameTouchedBody& body, std::size_t t) {
  return {body.haptic[t].ticks, 0};
}
inline void end_haptics(FrameTouchedBody& body) { body.haptic.clear(); }
inline Status begin_solutions(FrameTouchedBody&, bool) { return Done{}; }
void queue_frame_output(FrameTouchedBody& body);
void replay_frame_output(FrameTouchedBody& body, std::size_t t, TickInputs inputs_used);
inline void expect_patch(FrameTouchedBody&, bool) {}

/// Frame: sets the motion of the body's tools between the times `from` and `to`. The motion starts at the
/// previous command, or at the latest teleport, and ends at the newest command.
void apply_commands(FrameTouchedBody& body, double from, double to, std::vector<TouchingTool>& tools);
/// Frame: publishes the contact plane of tool `t` of tool_indices for the following ticks.
void publish_contact(FrameTouchedBody& body, std::size_t t, contact::LocalContact plane);

}  // namespace turgor
