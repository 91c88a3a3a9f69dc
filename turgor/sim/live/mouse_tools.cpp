#include "turgor/sim/live/mouse_tools.hpp"

#include <algorithm>

#include "turgor/geometry/box.hpp"
#include "turgor/sim/scene/scene_tool.hpp"

namespace turgor {

namespace {

bool has_tool(const Scene& scene, BodyId id) {
  return std::any_of(scene.tools.begin(), scene.tools.end(),
                     [id](const ToolScene& tool) { return tool.body == id; });
}

/// A lattice that is solved by position-based dynamics knows no contact, nor does cloth that is solved by
/// sweeps.
bool can_be_touched(const Scene& scene, BodyId id) {
  if (id.kind == BodyKind::kCloth) return why_untouched(scene.cloth_bodies[std::size_t(id.index)]).empty();
  if (id.kind != BodyKind::kLattice) return true;
  return scene.lattice_bodies[std::size_t(id.index)].params.solver.method == lattice::Method::kVbd;
}

/// In front of the body, before anything is asked of it.
ToolScene fingertip(BodyId id, const std::string& body) {
  constexpr double kNever = 1e6;  // [s]
  return {
      .name = "finger-" + body,
      .place = "the mouse's fingertip on " + body,
      .body = id,
      .shape = BallTool{.radius = 0.008},
      .friction = 0.3,
      .motion = Press{.at = {0.5, 0, 0.5}, .to = {}, .by_fraction = true, .depth = 0.001, .start = kNever}};
}

Box box_of(const RestSurface& surface, const TouchingTool& tool) {
  constexpr double kRoom = 0.3;  // [m]
  Box box = box_around(surface.vertices);
  for (const PathRow& row : tool.path.rows) box = {min(box.low, row.position), max(box.high, row.position)};
  return {box.low - Vec3d{kRoom, kRoom, kRoom}, box.high + Vec3d{kRoom, kRoom, kRoom}};
}

}  // namespace

Scene with_mouse_tools(const Scene& scene) {
  Scene with = scene;
  for_each_body(scene, [&](BodyId id, const auto& body) {
    if (can_be_touched(scene, id) && !has_tool(scene, id)) with.tools.push_back(fingertip(id, body.name));
  });
  return with;
}

Result<LiveHands> hold_mouse_tools(const World& world) {
  LiveHands hands;
  Status status = Done{};
  for_each_touched(world, [&](BodyId, const auto& body) {
    if (!status || body.tool_indices.empty()) return;
    const int index = body.tool_indices.front();
    const TouchingTool& tool = world.tools[std::size_t(index)];
    auto device = std::make_shared<haptics::MouseDevice>(box_of(rest_surface(body), tool));
    status = device->open();
    HeldTool& held = hands.held.emplace_back();
    held.tool = index, held.hand.device = device.get(), held.is_led = &device->is_led();
    held.hand.safety.ramp = 0.1;  // of a mouse, which hurts nobody [s]
    hands.mouse.push_back({index, std::move(device)});
  });
  if (!status) return status.error();
  return hands;
}

}  // namespace turgor
