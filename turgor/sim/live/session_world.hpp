// World of a session with its source, the mouse devices that hold its tools, and the haptic loop or clock
// that drives it.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/sim/live/frame_clock.hpp"
#include "turgor/sim/live/live_touch.hpp"
#include "turgor/sim/live/session.hpp"
#include "turgor/sim/loading.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// Source of the next world: a file or a scene.
struct SessionSource {
  OpenRequest file;
  std::shared_ptr<const Scene> scene;  // scene with all changes; null: to be read from `file`
};

/// A loaded world. All members are empty if no world is loaded.
struct SessionWorld {
  std::unique_ptr<World> world;  // must not move in memory
  std::vector<MouseTool> mouse;
  std::unique_ptr<LiveTouch> touch;  // must be destroyed before `world` and the devices, because it uses them
  std::optional<FrameClock> clock;   // used if there is no haptic loop
};

/// Reads the scene's file if there is no scene yet. Error: as read_scene.
Status read_source(SessionSource& source);
/// Loads a world with a tool for the mouse on every touchable body, and starts its haptic loop. Error: as
/// load_world, hold_mouse_tools and LiveTouch::start.
Result<SessionWorld> load_session_world(const Exec& exec, const Scene& scene, const SessionParams& params,
                                        const BeginWork& begin);
/// Stops the haptic loop, then destroys the world.
void unload(SessionWorld& live);

}  // namespace turgor
