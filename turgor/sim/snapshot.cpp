#include "turgor/sim/snapshot.hpp"

#include <algorithm>
#include <unordered_map>

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
  out.has_jaws = tool.forceps.has_value(), out.is_needle = tool.tool.needle.has_value();
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

namespace {

/// Calls add(position, weight) for the shown vertices that carry a point of a body of finite elements.
template <class Add>
void visit_shown(const BodySnapshot& shown, const std::unordered_map<int, std::size_t>& shown_of,
                 const contact::SurfacePoint& point, const Add& add) {
  for (int corner = 0; corner < 3; corner++) {
    const int vertex = point.vertex[corner];
    if (vertex < 0) continue;
    const auto found = shown.mesh_vertex.empty() ? std::size_t(vertex) : shown_of.at(vertex);
    add(Vec3d(shown.x[found]), point.weight[corner]);
  }
}

/// Adds the sum of forces on points of one body, unless it is zero.
template <class Each>
void add_organ_force(const World& world, const std::string& name, int body, const Each& for_each_point,
                     WorldSnapshot& out) {
  const BodyId id = coupled_body(world, body);
  const BodySnapshot& shown = body_snapshot(out, id);
  std::unordered_map<int, std::size_t> shown_of;  // index in the snapshot by vertex of the body's mesh
  for (std::size_t v = 0; v < shown.mesh_vertex.size(); v++) shown_of.emplace(shown.mesh_vertex[v], v);
  Pose pose;
  if (id.kind == BodyKind::kRigid) {
    const RigidBody& rigid = world.rigid_bodies[std::size_t(id.index)];
    pose = rigid::pose_of(rigid.model, rigid.state);
  }
  std::vector<Vec3d> moved;
  for (const CoupledSupport& support : world.coupling.supports)
    if (support.body == id) moved = support_displacement(world, support);
  OrganForce total{.name = name, .body = id};
  double weights = 0;
  for_each_point([&](const contact::SurfacePoint& point, Vec3d force) {
    total.force += force;
    const auto add = [&](Vec3d x, double share) {
      const double weight = norm(force) * share;
      total.at += x * weight, weights += weight;
    };
    if (id.kind == BodyKind::kRigid)
      add(to_world(pose, point.rest) + point.offset, 1);
    else if (id.kind != BodyKind::kSfem)
      add(point.rest + contact::displacement_of(point, moved), 1);
    else
      visit_shown(shown, shown_of, point, add);
  });
  if (!(weights > 0)) return;
  total.at = total.at / weights;
  out.organ_forces.push_back(std::move(total));
}

}  // namespace

void show_organ_forces(const World& world, WorldSnapshot& out) {
  out.organ_forces.clear();
  for (const Attachment& attachment : world.coupling.attachments)
    if (!attachment.ties.empty())
      add_organ_force(
          world, attachment.name, attachment.ties[0].a.body,
          [&](const auto& add) {
            for (const contact::Tie& tie : attachment.ties) add(tie.a, tie.force);
          },
          out);
  for (const BodyContact& contact : world.coupling.contacts)
    add_organ_force(
        world, contact.name, contact.body[0],
        [&](const auto& add) {
          for (const contact::PairSite& site : contact.sites)
            site.a.body == contact.body[0] ? add(site.a, site.force) : add(site.b, -site.force);
        },
        out);
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
  show_organ_forces(world, out);
  show_sections(exec, world, out);
}

}  // namespace turgor
