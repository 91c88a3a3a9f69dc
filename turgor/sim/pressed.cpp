#include "turgor/sim/pressed.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/timing.hpp"

namespace turgor {

namespace {

/// Force on all tools of a body together [N].
template <class Body>
double force_on(const World& world, const Body& body) {
  double force = 0;
  for (std::size_t t = 0; t < body.tool_indices.size(); t++) force += norm(tool_now(body, t, world).force);
  return force;
}

template <class Body>
void record_pressed(const Exec& exec, const World& world, const Body& body, double force, Pressed& pressed) {
  // time and name
  pressed.force = force, pressed.time = time_of(world);
  show_name(pressed.id, body, pressed.body);
  // draw the surface and time it
  const Timer timer;
  show(exec, body, pressed.body);
  pressed.surface_seconds.push_back(timer.seconds());
  // draw the tools
  pressed.tools.resize(body.tool_indices.size());
  for (std::size_t t = 0; t < pressed.tools.size(); t++) {
    TURGOR_CHECK(is_index(body.tool_indices[t], world.tools.size()),
                 "a body is touched by tools of its world");
    const ToolNow now = tool_now(body, t, world);
    show_tool(world.tools[std::size_t(body.tool_indices[t])], now.pose, now.force, now.opening,
              pressed.tools[t]);
  }
}

}  // namespace

std::vector<Pressed> make_pressed(const World& world) {
  std::vector<Pressed> pressed;
  for_each_touched(world, [&](BodyId id, const auto&) { pressed.push_back({.id = id}); });
  return pressed;
}

void update_pressed(const Exec& exec, const World& world, std::vector<Pressed>& pressed) {
  std::size_t next = 0;
  for_each_touched(world, [&](BodyId, const auto& body) {
    TURGOR_CHECK(next < pressed.size(), "every body that tools can touch is looked at");
    Pressed& one = pressed[next++];
    if (const double force = force_on(world, body); force > one.force)
      record_pressed(exec, world, body, force, one);
  });
}

void note_surface_seconds(const WorldSnapshot& snapshot, std::vector<Pressed>& pressed) {
  for (Pressed& one : pressed) one.surface_seconds.push_back(body_snapshot(snapshot, one.id).seconds);
}

const Pressed& pressed_body(const std::vector<Pressed>& pressed, BodyId id) {
  const auto found =
      std::find_if(pressed.begin(), pressed.end(), [id](const Pressed& one) { return one.id == id; });
  TURGOR_ASSERT(found != pressed.end(), "every body that tools can touch is looked at");
  return *found;
}

}  // namespace turgor
