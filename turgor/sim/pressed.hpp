// Bodies under the largest force of a run, recorded frame by frame. Recording does not change the world.
#pragma once

#include <vector>

#include "turgor/sim/snapshot.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// A body under the largest force of its tools so far.
struct Pressed {
  BodyId id;
  double force = 0;   // all its tools together; 0 = not touched yet [N]
  double time = 0;    // at that force [s]
  BodySnapshot body;  // at that force; empty before contact
  std::vector<ToolSnapshot> tools;
  std::vector<double> surface_seconds;  // wall times of filling the snapshot
};

/// One for every body that tools can touch.
std::vector<Pressed> make_pressed(const World& world);
/// After a frame: records bodies whose force exceeds all earlier ones.
void update_pressed(const Exec& exec, const World& world, std::vector<Pressed>& pressed);
/// After a snapshot: records its wall times.
void note_surface_seconds(const WorldSnapshot& snapshot, std::vector<Pressed>& pressed);

const Pressed& pressed_body(const std::vector<Pressed>& pressed, BodyId id);

}  // namespace turgor
