// Tools that a mouse can drive: the first tool of every body, or a fingertip for a body without tools.
#pragma once

#include <memory>
#include <vector>

#include "turgor/sim/live/live_touch.hpp"
#include "turgor/sim/live/session.hpp"

namespace turgor {

/// Scene with an additional fingertip for every touchable body without tools.
Scene with_mouse_tools(const Scene& scene);

struct LiveHands {
  std::vector<HeldTool> held;
  std::vector<MouseTool> mouse;  // devices of `held`, in the same order
};
/// Assigns the first tool of every body to a mouse device. The tool follows its path until the mouse drives
/// it. Error: as the device's open.
Result<LiveHands> hold_mouse_tools(const World& world);

}  // namespace turgor
