// Tools that a mouse may lead: those of a scene, and a fingertip for every body that has none.
#pragma once

#include <memory>
#include <vector>

#include "turgor/sim/live/live_touch.hpp"
#include "turgor/sim/live/session.hpp"

namespace turgor {

/// A fingertip waits beside every body that tools can touch and that none of the scene does.
Scene with_mouse_tools(const Scene& scene);

struct LiveHands {
  std::vector<HeldTool> held;
  std::vector<MouseTool> mouse;  // their devices
};
/// The first tool of every body goes on its path until the mouse leads it. Error: what the device's open
/// says.
Result<LiveHands> hold_mouse_tools(const World& world);

}  // namespace turgor
