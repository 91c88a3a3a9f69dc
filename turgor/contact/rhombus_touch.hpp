// Haptic touch of a rhombus body: the state owned by the haptic thread, and the snapshot that it publishes
// for the frame. Corresponds to sfem_touch.hpp. The frame sends only the stiffness and the waves of the
// surface, because a tick needs only the constant surface at rest.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "turgor/contact/forceps.hpp"
#include "turgor/contact/texture.hpp"
#include "turgor/contact/tool_io.hpp"
#include "turgor/core/latest.hpp"
#include "turgor/models/rhombus/rhombus.hpp"

namespace turgor::contact {

/// Contact geometry of a tool's end: a ball, or the gap between two jaws.
struct RhombusTip {
  Vec3d center;        // center of the ball, in the tool's frame [m]
  double radius = 0;   // [m]
  double opening = 0;  // distance between open jaws; 0 = no jaws [m]
};
/// Tip of the forceps if given, otherwise the lowest end (−z) of the shape.
RhombusTip rhombus_tip(const Shape& shape, const std::optional<Forceps>& forceps);
rhombus::TouchInput touch_input(const RhombusTip& tip, const Pose& pose, double grip);

/// Parameters of the body that may change while it is touched, published by the frame after a change.
struct RhombusTissue {
  double stiffness_scale = 1;  // relative to the model [1]
  Prony viscosity;
  Waves waves;      // of the surface
  long number = 0;  // of changes so far
};

/// State owned by the haptic thread.
struct RhombusTouch {
  std::vector<RhombusTip> tips;  // one per tool, like all vectors below
  std::vector<rhombus::ToolTouch> touches;
  std::vector<Pose> poses;  // of the last tick, as are the next two
  std::vector<rhombus::TouchInput> inputs;
  std::vector<rhombus::TouchForce> forces;  // with more detail than ToolReading, without texture
  long ticks = 0;                           // number of ticks so far
  RhombusTissue tissue;                     // latest, as published by the frame
  std::shared_ptr<const HeightMap> map;     // of the surface; null = none
  std::vector<TextureState> textures;       // of each tool
};
RhombusTouch make_rhombus_touch(std::vector<RhombusTip> tips, std::span<const Pose> poses,
                                const Prony& viscosity, const Texture& texture = {});

/// Tick of `dt` seconds with one command and one reading per tool. A tool holds tissue while its grip is
/// above 0. ToolCommand::hold has no effect, because next_grip has already turned it into the grip. Does not
/// allocate or wait.
void tick_rhombus_touch(const rhombus::Model& model, RhombusTouch& touch,
                        std::span<const ToolCommand> commands, double dt, std::span<ToolReading> readings);

/// Snapshot published for the frame. rhombus::step deforms the surface by `touches`.
struct RhombusTouchSnapshot {
  std::vector<rhombus::ToolTouch> touches;
  std::vector<Pose> poses;
  std::vector<rhombus::TouchInput> inputs;
  std::vector<rhombus::TouchForce> forces;
  long ticks = 0;  // number of ticks so far
  std::vector<TextureState> textures;
};
/// Fills a snapshot. Allocates in the first call only.
void publish(const RhombusTouch& touch, RhombusTouchSnapshot& now);

/// Tick of the haptic thread that also publishes a snapshot for the frame thread. Does not allocate or wait
/// if prepare() was called before the threads started.
void tick_and_publish(const rhombus::Model& model, RhombusTouch& touch, latest<RhombusTissue>& tissue,
                      latest<RhombusTouchSnapshot>& touched, std::span<const ToolCommand> commands, double dt,
                      std::span<ToolReading> readings);
void prepare(const RhombusTouch& touch, latest<RhombusTouchSnapshot>& touched);

}  // namespace turgor::contact
