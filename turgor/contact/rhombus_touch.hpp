// A body of rhombus while a hand feels it: what who ticks owns, and what that leaves for the frame, as
// sfem_touch.hpp has it for sfem. A tick needs nothing back from the frame: the surface at rest is its model.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "turgor/contact/forceps.hpp"
#include "turgor/contact/tool_io.hpp"
#include "turgor/core/latest.hpp"
#include "turgor/models/rhombus/rhombus.hpp"

namespace turgor::contact {

/// The end of a tool that a body of rhombus feels: a ball, or what is between two jaws.
struct RhombusTip {
  Vec3d center;        // of the ball, in the tool's frame [m]
  double radius = 0;   // [m]
  double opening = 0;  // of open jaws; 0 = the tool has none [m]
};
/// The lowest end of a shape, or the tip of forceps if they are any.
RhombusTip rhombus_tip(const Shape& shape, const std::optional<Forceps>& forceps);
rhombus::TouchInput touch_input(const RhombusTip& tip, const Pose& pose, double grip);

/// What who ticks owns.
struct RhombusTouch {
  std::vector<RhombusTip> tips;            // of the tools
  std::vector<rhombus::Touching> touches;  // one a tool, as the three below
  std::vector<Pose> poses;                 // of the last tick, as the two below
  std::vector<rhombus::TouchInput> inputs;
  std::vector<rhombus::TouchForce> forces;  // in more detail than ToolReading
  long ticks = 0;                           // so far
};
RhombusTouch make_rhombus_touch(std::vector<RhombusTip> tips, std::span<const Pose> poses);

/// One tick of `dt` seconds: commands in, readings out, one a tool. A tool holds while its grip is not 0;
/// ToolCommand::hold is for who makes the grip of it (next_grip). Neither allocates nor waits.
void tick(const rhombus::Model& model, RhombusTouch& touch, std::span<const ToolCommand> commands, double dt,
          std::span<ToolReading> readings);

/// What ticks leave for the frame: rhombus::step moves the surface by `touches`.
struct RhombusTouchedNow {
  std::vector<rhombus::Touching> touches;
  std::vector<Pose> poses;
  std::vector<rhombus::TouchInput> inputs;
  std::vector<rhombus::TouchForce> forces;
  long ticks = 0;  // so far
};
/// Allocates nothing from the second time on.
void publish(const RhombusTouch& touch, RhombusTouchedNow& now);

/// A tick of a haptic thread, which leaves that for the thread that makes frames. Neither allocates nor waits
/// once prepare has been called, before either thread begins.
void tick(const rhombus::Model& model, RhombusTouch& touch, latest<RhombusTouchedNow>& touched,
          std::span<const ToolCommand> commands, double dt, std::span<ToolReading> readings);
void prepare(const RhombusTouch& touch, latest<RhombusTouchedNow>& touched);

}  // namespace turgor::contact
