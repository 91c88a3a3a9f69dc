// What passes between a haptic thread and the frames of a body whose forces are known once a frame: for each
// of its tools a command one way and a plane the other way (contact/local_contact.hpp). Bodies of sfem and
// rhombus have an exchange of their own; every body that tools touch has overloads of the same names:
//
//   begin_felt    before the haptic thread begins: `felt` is there, and frames do not tick any more
//   tick_felt     of the haptic thread: a command and a reading for each of its tools
//   log_tick      likewise, for each of them
//   tick_knew     likewise: what that tick answered from; frame_knew is the frame's
//   end_felt      when there is no haptic thread any more
//
// and two for who does it again (haptic_replay.hpp): keep_frame after a frame, give_frame before a tick.
#pragma once

#include <span>
#include <vector>

#include "turgor/contact/local_contact.hpp"
#include "turgor/sim/live/tick_inputs.hpp"
#include "turgor/sim/tools/touched_body.hpp"

namespace turgor {

struct NumberedCommand {
  contact::ToolCommand command;
  std::int32_t number = 0;     // of the ticks so far
  std::int32_t teleports = 0;  // how often it was put elsewhere so far: farther than a hand moves in a tick
  contact::Pose put;           // where, the last time
};

/// Of one tool.
struct LocalExchange {
  latest<NumberedCommand> command;      // of the haptic thread, to the frame
  latest<contact::LocalContact> plane;  // of the frame, to the haptic thread

  // The frame's:
  contact::ToolCommand before;  // where the tool was a frame ago
  std::int32_t ticks = 0;       // NumberedCommand::number of that
  std::int32_t teleports = 0;   // and its puts
  bool was_teleported = false;  // since the frame before: to `before`, and nothing lay on its way there
  contact::LocalMemory memory;
  long planes = 0;  // so far
  Awaiting<contact::LocalContact> awaiting;

  // The haptic thread's:
  contact::LocalTouch touch;
  NumberedCommand latest_tick;
  double age = 0;  // of the newest plane [s]
};

/// A body whose forces are known once a frame. `felt`: one for each of tool_indices while a hand feels it,
/// else none.
struct FrameTouchedBody : TouchedBody {
  std::vector<LocalExchange> haptic;
};

void begin_haptics(FrameTouchedBody& body, const std::vector<TouchingTool>& tools);
void tick_haptics(FrameTouchedBody& body, std::span<const contact::ToolCommand> commands, double dt,
                  std::span<contact::ToolReading> readings);
inline void log_tick(FrameTouchedBody&, std::size_t, const ForceSample& sample, TouchingTool& tool) {
  tool.samples.append(sample);
}
inline TickInputs tick_inputs(const FrameTouchedBody& body, std::size_t t) {
  return {std::int32_t(body.haptic[t].touch.contact.number), 0};
}
inline FrameInputs frame_inputs(const FrameTouchedBody& body, std::size_t t) {
  return {body.haptic[t].ticks, 0};
}
inline void end_haptics(FrameTouchedBody& body) { body.haptic.clear(); }
void keep_frame(FrameTouchedBody& body);
void give_frame(FrameTouchedBody& body, std::size_t t, TickInputs inputs_used);
inline void expect_patch(FrameTouchedBody&, bool) {}

/// Of the frame: the way of the tools of a body from one time to another, from where they were, or were put
/// since, to where the haptic thread has them now.
void take_commands(FrameTouchedBody& body, double from, double to, std::vector<TouchingTool>& tools);
/// Of the frame: what ticks feel of tool `t` of tool_indices from now on.
void leave_plane(FrameTouchedBody& body, std::size_t t, contact::LocalContact plane);

}  // namespace turgor
