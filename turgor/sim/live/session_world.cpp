#include "turgor/sim/live/session_world.hpp"

#include <utility>

#include "turgor/sim/live/mouse_tools.hpp"

namespace turgor {

Status read_source(SessionSource& source) {
  if (source.scene) return Done{};
  Result<Scene> read = read_scene(source.file.file, source.file.overrides);
  if (!read) return read.error();
  source.scene = std::make_shared<const Scene>(std::move(*read));
  return Done{};
}

Result<SessionWorld> load_session_world(const Exec& exec, const Scene& scene, const SessionParams& params,
                                        const BeginWork& begin) {
  // world with tools for the mouse
  SessionWorld live;
  Result<World> loaded = load_world(exec, with_mouse_tools(scene), begin);
  if (!loaded) return loaded.error();
  live.world = std::make_unique<World>(std::move(*loaded));
  live.clock.emplace(live.world->dt);

  // haptic loop
  Result<LiveHands> hands = hold_mouse_tools(*live.world);
  if (!hands) return hands.error();
  live.mouse = hands->mouse;
  if (!hands->held.empty()) {
    auto started = LiveTouch::start(*live.world, hands->held, {params.loop, params.longest});
    if (!started) return started.error();
    live.touch = std::move(*started);
  }
  return live;
}

void unload(SessionWorld& live) {
  if (live.touch) live.touch->stop();
  live.touch.reset(), live.clock.reset(), live.mouse.clear(), live.world.reset();
}

}  // namespace turgor
