// What a run remembers of the bodies that tools touch: how each lay under the largest force. It looks on,
// frame by frame; nothing of it goes back into the world.
#pragma once

#include <vector>

#include "turgor/sim/snapshot.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// A body under the largest force of its tools so far.
struct Pressed {
  BodyId id;
  double force = 0;   // of all its tools together; 0 = it was not touched yet [N]
  double time = 0;    // then [s]
  BodySnapshot body;  // then; before it is touched, nothing
  std::vector<ToolSnapshot> tools;
  std::vector<double> surface_seconds;  // wall times of showing it
};

/// One for every body that tools can touch.
std::vector<Pressed> make_pressed(const World& world);
/// After a frame: remembers the bodies whose force is larger than ever.
void look_at_pressed(const Exec& exec, const World& world, std::vector<Pressed>& pressed);
/// After the world was shown: notes how long that took.
void note_surface_seconds(const WorldSnapshot& snapshot, std::vector<Pressed>& pressed);

const Pressed& pressed_body(const std::vector<Pressed>& pressed, BodyId id);

}  // namespace turgor
