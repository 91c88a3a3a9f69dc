#include "turgor/sim/live/mouse_tools.hpp"

#include <algorithm>
#include <limits>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/geometry/box.hpp"
#include "turgor/sim/scene/scene_tool.hpp"

namespace turgor {

namespace {

bool has_tool(const Scene& scene, BodyId id) {
  return std::any_of(scene.tools.begin(), scene.tools.end(),
                     [id](const ToolScene& tool) { return tool.body == id; });
}

/// True if the body has contact with tools. Lattices solved by PBD and cloth solved by sweeps have none.
bool can_be_touched(const Scene& scene, BodyId id) {
  TURGOR_CHECK(id.kind != BodyKind::kCloth || is_index(id.index, scene.cloth_bodies.size()),
               "a cloth of the scene");
  if (id.kind == BodyKind::kCloth) return why_untouched(scene.cloth_bodies[std::size_t(id.index)]).empty();
  if (id.kind != BodyKind::kLattice) return true;
  return scene.lattice_bodies[std::size_t(id.index)].params.solver.method == lattice::Method::kVbd;
}

/// Distance at which a fingertip waits: no wound opens up to it, and no swinging cloth reaches it [m].
double waiting_distance(const Scene& scene, BodyId id) {
  constexpr double kOfTissue = 0.05, kOfGarment = 2;
  if (id.kind != BodyKind::kCloth) return kOfTissue;
  const auto* sheet = std::get_if<cloth::Sheet>(&scene.cloth_bodies[std::size_t(id.index)].source);
  return sheet ? norm(sheet->side) + norm(sheet->up) : kOfGarment;
}

/// Fingertip that waits in front of the body until the mouse drives it.
ToolScene fingertip(BodyId id, const std::string& body, double distance) {
  constexpr double kNever = 1e6;  // [s]
  return {.name = "finger-" + body,
          .source_location = "the mouse's fingertip on " + body,
          .body = id,
          .shape = BallTool{.radius = 0.008},
          .friction = 0.3,
          .motion = Press{.at = {0.5, 0, 0.5},
                          .to = {},
                          .by_fraction = true,
                          .depth = 0.001,
                          .start = kNever,
                          .clearance = distance}};
}

Box box_of(const RestSurface& surface, const TouchingTool& tool) {
  constexpr double kMargin = 0.3;  // [m]
  Box box = box_around(surface.vertices);
  for (const PathRow& row : tool.path.rows) box = {min(box.low, row.position), max(box.high, row.position)};
  return {box.low - Vec3d{kMargin, kMargin, kMargin}, box.high + Vec3d{kMargin, kMargin, kMargin}};
}

}  // namespace

Scene with_mouse_tools(const Scene& scene) {
  Scene with = scene;
  for_each_body(scene, [&](BodyId id, const auto& body) {
    if (can_be_touched(scene, id) && !has_tool(scene, id))
      with.tools.push_back(fingertip(id, body.name, waiting_distance(scene, id)));
  });
  return with;
}

Result<LiveHands> hold_mouse_tools(const World& world) {
  LiveHands hands;
  Status status = Done{};
  for_each_touched(world, [&](BodyId, const auto& body) {
    if (!status || body.tool_indices.empty()) return;
    const int index = body.tool_indices.front();
    TURGOR_CHECK(is_index(index, world.tools.size()), "a held tool is a tool of the world");
    const TouchingTool& tool = world.tools[std::size_t(index)];
    auto device = std::make_shared<haptics::MouseDevice>(box_of(rest_surface(body), tool));
    status = device->open();
    HeldTool& held = hands.held.emplace_back();
    held.tool = index, held.hand.device = device.get(), held.is_driven = &device->is_driven();
    // a mouse renders no force: the ramp is short, and an old force supports the tool until the next one
    held.hand.safety.ramp = 0.1;  // [s]
    held.hand.safety.silence = std::numeric_limits<double>::infinity();
    held.keeps_force = true;
    hands.mouse.push_back({index, std::move(device)});
  });
  if (!status) return status.error();
  return hands;
}

}  // namespace turgor
