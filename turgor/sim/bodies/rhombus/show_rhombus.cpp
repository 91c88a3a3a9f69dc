// Frame of a rhombus body: its ticks, surface update and snapshot.
#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/sim/smooth_snapshot.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

void step_body(const Exec& exec, RhombusBody& body, World& world, const FrameInput& input, FrameReport&) {
  publish_tissue(body);
  if (body.haptic) {
    body.now = body.haptic->touched.read();
    read_touch_snapshot(body);
  } else {
    touch_body(body, world.tools, input.from, input.to);
  }
  const rhombus::StepReport moved = rhombus::step(exec, body.model, body.state);
  body.pressed_volume = std::max(body.pressed_volume, moved.pressed_volume);
}

std::uint64_t state_hash(const RhombusBody& body, std::uint64_t seed) {
  const std::uint64_t one = rhombus::state_hash(body.state);
  return hash_bytes(&one, sizeof one, seed);
}

ToolNow tool_now(const RhombusBody& body, std::size_t t, const World&) {
  TURGOR_CHECK(is_index(t, body.now.poses.size()), "every tool has a pose");
  return {body.now.poses[t], body.now.forces[t].force, body.now.inputs[t].opening};
}

void show(const Exec&, const RhombusBody& body, BodySnapshot& out) {
  const std::vector<Vec3d>& rest = body.model.surface.vertices;
  TURGOR_CHECK(body.state.displacement.size() == rest.size(), "every vertex has a displacement");
  out.triangles = body.model.surface.triangles;
  out.mesh_vertex = body.mesh_vertex;
  out.wall_begin = out.triangles.size();
  out.rest.resize(rest.size()), out.displacement.resize(rest.size());
  for (std::size_t v = 0; v < rest.size(); v++) {
    out.rest[v] = Vec3(rest[v]);
    out.displacement[v] = Vec3(body.state.displacement[v]);
  }
  update_vertices(out);
  set_coarse(body.model.surface.triangles, out);
}

}  // namespace turgor
