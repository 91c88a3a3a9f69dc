#include "turgor/sim/snapshot.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

double diagonal(const TriMesh& mesh) {
  if (mesh.vertices.empty()) return 0;
  Vec3 low = mesh.vertices[0], high = low;
  for (const Vec3 x : mesh.vertices) low = min(low, x), high = max(high, x);
  return norm(Vec3d(high) - Vec3d(low));
}

template <class AnyShown>
auto& find_body(AnyShown& snapshot, BodyId id) {
  const auto found = std::find_if(snapshot.bodies.begin(), snapshot.bodies.end(),
                                  [id](const BodySnapshot& body) { return body.id == id; });
  TURGOR_ASSERT(found != snapshot.bodies.end(), "a shown world has all bodies of its world");
  return *found;
}

}  // namespace

BodySnapshot& body_snapshot(WorldSnapshot& snapshot, BodyId id) { return find_body(snapshot, id); }
const BodySnapshot& body_snapshot(const WorldSnapshot& snapshot, BodyId id) {
  return find_body(snapshot, id);
}

std::vector<ToolSnapshot> tools_on(const WorldSnapshot& snapshot, BodyId id) {
  std::vector<ToolSnapshot> tools;
  for (const ToolSnapshot& tool : snapshot.tools)
    if (tool.body == id) tools.push_back(tool);
  return tools;
}

void update_vertices(BodySnapshot& body) {
  TURGOR_CHECK(body.displacement.size() == body.rest.size(), "every vertex has a displacement");
  body.x.resize(body.rest.size());
  for (std::size_t v = 0; v < body.x.size(); v++) body.x[v] = body.rest[v] + body.displacement[v];
  TriMesh mesh;  // borrows the arrays for vertex_normals
  mesh.vertices.swap(body.x), mesh.triangles.swap(body.triangles);
  body.normals = vertex_normals(mesh);
  mesh.vertices.swap(body.x), mesh.triangles.swap(body.triangles);
  if (body.rest.empty()) return;
  body.box = {Vec3d(body.rest[0]), Vec3d(body.rest[0])};
  for (const Vec3 x : body.rest) body.box = {min(body.box.low, Vec3d(x)), max(body.box.high, Vec3d(x))};
}

void show_tool(const TouchingTool& tool, const contact::Pose& pose, Vec3d force, double opening,
               ToolSnapshot& out) {
  out.name = tool.name, out.body = tool.body;
  out.pose = pose, out.force = force, out.opening = opening;
  out.has_jaws = tool.forceps.has_value();
  out.size = tool.forceps ? 3 * tool.forceps->opening : diagonal(tool.mesh);
  out.mesh = tool.forceps ? contact::forceps_mesh(*tool.forceps, opening) : tool.mesh;
}

void show_names(const World& world, WorldSnapshot& out) {
  out.time = time_of(world), out.frame = world.frame;
  std::size_t count = 0;
  for_each_body(world, [&](BodyId id, const auto& body) {
    if (count == out.bodies.size()) out.bodies.emplace_back();
    show_name(id, body, out.bodies[count++]);
  });
  out.bodies.resize(count);
  out.tools.resize(world.tools.size());
  std::size_t obstacles = 0;
  for (const ClothBody& body : world.cloth_bodies)
    for (const ClothObstacle& obstacle : body.obstacles) {
      if (obstacle.mesh.triangles.empty()) continue;
      if (obstacles == out.obstacles.size()) out.obstacles.emplace_back();
      out.obstacles[obstacles++] = obstacle.mesh;
    }
  out.obstacles.resize(obstacles);
}

void show_threads(const World& world, WorldSnapshot& out) {
  out.threads.resize(world.sutures.size());
  for (std::size_t s = 0; s < world.sutures.size(); s++) {
    const Suture& suture = world.sutures[s];
    out.threads[s] = thread_mesh(world.lattice_bodies[std::size_t(suture.scene.body)], suture);
  }
}

void show(const Exec& exec, const World& world, WorldSnapshot& out) {
  show_names(world, out);
  show_threads(world, out);
  for_each_body(world, [&](BodyId id, const auto& body) {
    BodySnapshot& snapshot = body_snapshot(out, id);
    const Timer timer;
    show(exec, body, snapshot);
    snapshot.seconds = timer.seconds();
    if constexpr (is_touched<decltype(body)>)
      for (std::size_t t = 0; t < body.tool_indices.size(); t++) {
        TURGOR_CHECK(is_index(body.tool_indices[t], out.tools.size()), "a snapshot has every tool");
        const auto n = std::size_t(body.tool_indices[t]);
        const ToolNow now = tool_now(body, t, world);
        show_tool(world.tools[n], now.pose, now.force, now.opening, out.tools[n]);
      }
  });
}

}  // namespace turgor
