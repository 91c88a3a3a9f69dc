#include "turgor/sim/bodies/rigid/rigid_body.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/geometry/ball_mesh.hpp"
#include "turgor/geometry/surface_check.hpp"
#include "turgor/io/mesh/surface_files.hpp"
#include "turgor/io/mesh/unit_question.hpp"
#include "turgor/sim/tools/tool_mesh.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

constexpr int kBallHalvings = 4;  // of a drawn ball

/// Surface and round shape about the origin.
struct LoadedShape {
  TriMesh mesh;
  rigid::RoundShape round;
};

TriMesh box_mesh(Vec3d size) {
  TriMesh mesh;
  for (int n = 0; n < 8; n++)
    mesh.vertices.push_back(Vec3(hadamard(size, {(n & 1) - 0.5, (n >> 1 & 1) - 0.5, (n >> 2) - 0.5})));
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

Result<TriMesh> load_surface(const Exec& exec, const SurfaceFile& file, std::vector<std::string>& notes) {
  Result<ReadSurface> read = read_surface(file.file, file.scale);
  if (!read) return read.error();
  if (const Status unit = check_unit(file.file, read->mesh.vertices, file.is_scale_given); !unit)
    return unit.error();
  turn_up(read->mesh.vertices, file.up);
  Result<CheckedSurface> checked = check_surface(exec, read->mesh);
  if (!checked) return Error{fmt::format("{}: {}", file.file.string(), checked.error().message)};
  notes = read->notes;
  notes.insert(notes.end(), checked->notes.begin(), checked->notes.end());
  return std::move(checked->mesh);
}

Result<LoadedShape> load_rigid_shape(const Exec& exec, const RigidShape& shape,
                                     std::vector<std::string>& notes) {
  if (const auto* box = std::get_if<BoxSize>(&shape)) return LoadedShape{box_mesh(box->size), {}};
  if (const auto* ball = std::get_if<BallTool>(&shape))
    return LoadedShape{ball_mesh(ball->radius, kBallHalvings), {.radius = ball->radius, .ends = {}}};
  if (const auto* rod = std::get_if<RodTool>(&shape)) {
    const Vec3d end{0, 0, rod->half_length};
    return LoadedShape{capsule_mesh(rod->radius, rod->half_length),
                       {.radius = rod->radius, .ends = {-end, end}}};
  }
  Result<TriMesh> mesh = load_surface(exec, std::get<SurfaceFile>(shape), notes);
  if (!mesh) return mesh.error();
  return LoadedShape{std::move(*mesh), {}};
}

/// Vertices of their own for every triangle whose corners have another normal, so that edges look sharp.
TriMesh with_sharp_edges(const TriMesh& mesh) {
  constexpr Real kSharp = 0.7F;  // cosine between the normals of a triangle and of its corner
  const std::vector<Vec3> normals = vertex_normals(mesh);
  TriMesh drawn;
  drawn.vertices = mesh.vertices;
  for (Int3 t : mesh.triangles) {
    const auto x = [&](int v) { return mesh.vertices[std::size_t(v)]; };
    const Vec3 normal = normalized(cross(x(t.y) - x(t.x), x(t.z) - x(t.x)));
    for (int corner = 0; corner < 3; corner++) {
      const int v = t[corner];
      if (dot(normal, normals[std::size_t(v)]) > kSharp) continue;
      t[corner] = int(drawn.vertices.size());
      drawn.vertices.push_back(x(v));
    }
    drawn.triangles.push_back(t);
  }
  return drawn;
}

/// Moves the shape to its initial pose.
void set_pose(const RigidScene& scene, const LoadedShape& shape, rigid::Model& model) {
  const Pose pose{scene.at, axes_of(rigid::rotation_of(scene.turn))};
  for (const Vec3 x : shape.mesh.vertices) model.vertices.push_back(to_world(pose, Vec3d(x)));
  model.triangles = shape.mesh.triangles;
  model.round = {shape.round.radius,
                 {to_world(pose, shape.round.ends[0]), to_world(pose, shape.round.ends[1])}};
}

}  // namespace

Result<RigidBody> load_body(const Loading& loading, const RigidScene& scene, const World& world) {
  RigidBody body;
  body.name = scene.name;
  body.touch_stiffness = scene.touch_stiffness, body.typical_force = 0.01 * scene.touch_stiffness;
  if (loading.purpose == Purpose::kDraw) return body;
  // shape
  Result<LoadedShape> shape = load_rigid_shape(loading.exec, scene.shape, body.notes);
  if (!shape) return Error{fmt::format("{}: {}", scene.source_location, shape.error().message)};
  rigid::Model& model = body.model;
  set_pose(scene, *shape, model);
  model.is_fixed = scene.is_fixed;
  body.drawn = with_sharp_edges(mesh_of(model.vertices, model.triangles));
  // mass
  const double density = scene.density > 0 ? scene.density : 1;
  Result<rigid::MassProperties> mass = model.round.radius > 0
                                           ? rigid::mass_of_round(model.round, density)
                                           : rigid::mass_of_mesh(model.vertices, model.triangles, density);
  if (!mass) return Error{fmt::format("{}: {}", scene.source_location, mass.error().message)};
  model.mass = scene.mass > 0 ? rigid::with_mass(*mass, scene.mass) : *mass;
  for (const Vec3d x : model.vertices) body.radius = std::max(body.radius, norm(x - model.mass.center));
  // the velocity is that of the middle of a frame, which begins at half a frame before the start
  const Vec3d half = scene.is_fixed ? Vec3d{} : world.gravity * (0.5 * world.dt);
  body.state = rigid::make_state(model, scene.velocity - half, scene.spin);
  body.next = body.state;
  return body;
}

void step_body(const Exec& exec, RigidBody& body, World& world, const FrameInput& input,
               FrameReport& report) {
  apply_commands(body, input.from, input.to, world.tools);
  const rigid::State& next = body.next;
  if (!is_finite(next.center) || !is_finite(next.momentum) || !is_finite(next.velocity)) {
    report.finite = false;
    return;
  }
  body.state = next;
  body.samples.push_back(
      {input.to, next.center, next.rotation, next.velocity, rigid::spin_of(body.model, next)});
  report.largest_speed = std::max(report.largest_speed, rigid::largest_speed(body.model, next));
  record_touch(exec, body, world, input.to);
}

/// Compliance over a frame: h² (1/m + r²/J) bounds the displacement of every point by a force.
void press_body(const Exec&, RigidBody& body, const ClothForces& push, double dt) {
  ClothLoad& load = body.cloth;
  const rigid::MassProperties& mass = body.model.mass;
  const double least = std::min({mass.moments.x, mass.moments.y, mass.moments.z});
  const double compliance = dt * dt * (1 / mass.mass + body.radius * body.radius / least);
  load.compliance = {compliance, compliance, compliance};
  if (body.model.is_fixed) load.compliance = {}, load.relaxation = 1;
  choose_relaxation(push.mass, dt, load);
  relax_toward(push, load);
}

contact::RigidLoad cloth_load_on(const RigidBody& body) {
  const Pose pose = rigid::pose_of(body.model, body.state);
  contact::RigidLoad load = body.borne;
  for (const auto& [vertex, force] : body.cloth.force) {
    const Vec3d arm = to_world(pose, body.model.vertices[std::size_t(vertex)]) - body.state.center;
    load.force += force, load.torque += cross(arm, force);
  }
  return load;
}

std::uint64_t state_hash(const RigidBody& body, std::uint64_t seed) {
  return hash_bytes(&body.state, sizeof body.state, seed);
}

void show(const Exec&, const RigidBody& body, BodySnapshot& out) {
  const Pose pose = rigid::pose_of(body.model, body.state);
  out.rest = body.drawn.vertices, out.triangles = body.drawn.triangles;
  out.wall_begin = out.triangles.size();
  out.displacement.resize(out.rest.size());
  for (std::size_t v = 0; v < out.rest.size(); v++) {
    const Vec3d rest(out.rest[v]);
    out.displacement[v] = Vec3(to_world(pose, rest) - rest);
  }
  update_vertices(out);
}

}  // namespace turgor
