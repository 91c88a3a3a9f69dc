#include <algorithm>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/geometry/body_location.hpp"
#include "turgor/io/mesh/surface_files.hpp"
#include "turgor/io/mesh/unit_question.hpp"
#include "turgor/models/cloth/build/scale_stiffness.hpp"
#include "turgor/models/cloth/device/gpu_sheet.hpp"
#include "turgor/sim/bodies/cloth/cloth_body.hpp"
#include "turgor/sim/bodies/cloth/upload_cloth.hpp"
#include "turgor/sim/tools/tool_mesh.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

Result<TriMesh> read_garment_file(const GarmentFile& garment, std::vector<std::string>& notes) {
  Result<ReadSurface> read = read_surface(garment.file, garment.scale);
  if (!read) return read.error();
  const Status unit = check_unit(garment.file, read->mesh.vertices, garment.is_scale_given, Meshed::kGarment);
  if (!unit) return unit.error();
  notes.insert(notes.end(), read->notes.begin(), read->notes.end());
  TriMesh mesh = std::move(read->mesh);
  for (Vec3& x : mesh.vertices) x = turned_up(x, garment.up) + Vec3(garment.shift);
  mesh.normals.clear();
  return mesh;
}

/// Axes whose z axis is a given direction.
Mat3d axes_along(Vec3d z) {
  TURGOR_CHECK(is_unit(z), "an axis is a unit vector");
  const Vec3d aside = std::abs(z.x) < 0.9 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  const Vec3d y = normalized(cross(z, aside));
  return {{cross(y, z), y, z}};
}

TriMesh placed(TriMesh mesh, const contact::Pose& pose) {
  for (Vec3& x : mesh.vertices) x = Vec3(contact::to_world(pose, Vec3d(x)));
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

/// Square around a point, for drawing.
TriMesh shown_plane(const PlaneScene& plane, double size) {
  const Mat3d axes = axes_along(normalized(plane.normal));
  const Vec3d side = axes.column[0] * size, up = axes.column[1] * size;
  TriMesh mesh = cloth::make_sheet({plane.through - (side + up) * 0.5, side, up, 1, 1});
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

Result<ClothObstacle> load_obstacle(const ObstacleScene& scene, ClothBody& body) {
  ClothObstacle obstacle{.name = scene.name, .friction = scene.friction, .gap = scene.gap};
  if (const auto* plane = std::get_if<PlaneScene>(&scene.shape)) {
    obstacle.plane = *plane;
    obstacle.mesh = shown_plane(*plane, 1.5 * std::sqrt(body.model.area));
  } else if (const auto* ball = std::get_if<BallScene>(&scene.shape)) {
    obstacle.shape = contact::Sphere{ball->radius};
    obstacle.pose.position = ball->center;
    obstacle.mesh = placed(capsule_mesh(ball->radius, 0), obstacle.pose);
  } else if (const auto* rod = std::get_if<RodScene>(&scene.shape)) {
    const Vec3d along = rod->to - rod->from;
    obstacle.shape = contact::Capsule{rod->radius, norm(along) / 2};
    obstacle.pose = {(rod->from + rod->to) * 0.5,
                     axes_along(norm(along) > 0 ? normalized(along) : Vec3d{0, 0, 1})};
    obstacle.mesh = placed(capsule_mesh(rod->radius, norm(along) / 2), obstacle.pose);
  } else if (const auto* file = std::get_if<GarmentFile>(&scene.shape)) {
    Result<TriMesh> mesh = read_garment_file(*file, body.notes);
    if (!mesh) return mesh.error();
    obstacle.surface = cloth::moving_surface(*mesh, {}, 0);
    mesh->normals = vertex_normals(*mesh);
    obstacle.mesh = std::move(*mesh);
  } else {
    obstacle.support.emplace().body = std::get<BodyId>(scene.shape);
  }
  return obstacle;
}

Result<ClothHold> load_hold(const HoldScene& scene, const TriMesh& mesh, const cloth::Model& model) {
  ClothHold hold{.scene = scene, .vertices = scene.vertices};
  const int count = int(mesh.vertices.size());
  for (const int v : scene.vertices)
    if (v >= count)
      return Error{
          fmt::format("hold.{}: expected vertices from 0 to {}, found {}", scene.name, count - 1, v)};
  for (int v = 0; scene.box && v < count; v++) {
    const Vec3d x(mesh.vertices[std::size_t(v)]), low = (*scene.box)[0], high = (*scene.box)[1];
    if (max(min(x, high), low) == x) hold.vertices.push_back(v);
  }
  if (hold.vertices.empty() && !scene.ball)
    return Error{fmt::format("hold.{}: no vertex of the cloth is in the box; {}", scene.name,
                             describe_location(std::vector<Vec3d>(mesh.vertices.begin(), mesh.vertices.end()),
                                               ((*scene.box)[0] + (*scene.box)[1]) * 0.5))};
  // unique vertices, since several may have been merged
  const auto model_vertex = [&model](int v) { return model.model_vertex[std::size_t(v)]; };
  std::sort(hold.vertices.begin(), hold.vertices.end(),
            [&](int a, int b) { return model_vertex(a) < model_vertex(b); });
  hold.vertices.erase(std::unique(hold.vertices.begin(), hold.vertices.end(),
                                  [&](int a, int b) { return model_vertex(a) == model_vertex(b); }),
                      hold.vertices.end());
  return hold;
}

/// Sentences about a law or a method whose results depend on the mesh.
std::vector<std::string> notes_on_accuracy(const cloth::Params& params) {
  std::vector<std::string> notes;
  if (params.fabric.law == cloth::Law::kSprings)
    notes.emplace_back(
        "fabric.law = \"springs\": the mass-spring system of the paper, for its comparison; its stiffness "
        "depends on the mesh, that of \"sheet\" does not");
  if (!cloth::uses_conjugate_gradients(params.solver.method))
    notes.push_back(
        fmt::format("solver.method: {} sweeps a frame do not check the residual; fine or stiff cloth may sag "
                    "too little, and \"two_level\" converges at any mesh",
                    params.solver.sweeps));
  return notes;
}

/// Force of a strain of 0.001 per meter of width [N].
double typical_force(const cloth::Fabric& fabric) { return 1e-3 * std::sqrt(fabric.warp * fabric.weft); }

/// Uploads model and state. Returns the GPU.
Result<Gpu> use_gpu(ClothBody& body) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) return Error{"device = \"gpu\": " + gpu.error().message};
  Result<std::shared_ptr<cloth::SheetBackend>> backend = put(*gpu, body.model);
  if (!backend) return Error{"device = \"gpu\": " + backend.error().message};
  body.state.use_backend(std::move(*backend));
  return gpu;
}

}  // namespace

Status upload_to_gpu(ClothBody& body) {
  const Result<Gpu> gpu = use_gpu(body);
  if (!gpu) return gpu.error();
  body.notes.push_back("steps on " + gpu->name);
  return Done{};
}

void upload_changed_model(ClothBody& body) {
  body.state.use_backend(nullptr);  // frees the former model
  if (const Result<Gpu> gpu = use_gpu(body); !gpu)
    body.notes.push_back("steps on the host since its last change: " + gpu.error().message);
}

Result<ClothBody> load_body(const Loading& loading, const ClothScene& scene, const World&) {
  ClothBody body;
  body.name = scene.name, body.air = scene.air, body.turns = scene.turns;
  const auto failed = [&](const Error& error) {
    return Error{fmt::format("{}: {}", scene.source_location, error.message)};
  };
  const Timer timer;
  TriMesh mesh;
  if (const auto* sheet = std::get_if<cloth::Sheet>(&scene.source)) {
    mesh = cloth::make_sheet(*sheet);
  } else {
    Result<TriMesh> read = read_garment_file(std::get<GarmentFile>(scene.source), body.notes);
    if (!read) return failed(read.error());
    mesh = std::move(*read);
  }
  Result<cloth::Model> model = cloth::build(loading.exec, mesh, scene.params);
  if (!model) return failed(model.error());
  body.model = std::move(*model);
  if (scene.stiffness_scale != 1) cloth::scale_stiffness(scene.stiffness_scale, body.model);
  body.fabric = scene.params.fabric, body.stiffness_scale = scene.stiffness_scale;
  body.state = cloth::make_state(body.model);
  body.notes.insert(body.notes.end(), body.model.notes.begin(), body.model.notes.end());
  for (std::string& note : notes_on_accuracy(scene.params)) body.notes.push_back(std::move(note));
  for (const HoldScene& hold_scene : scene.holds) {
    Result<ClothHold> hold = load_hold(hold_scene, mesh, body.model);
    if (!hold) return failed(hold.error());
    body.holds.push_back(std::move(*hold));
  }
  for (const ObstacleScene& obstacle_scene : scene.obstacles) {
    Result<ClothObstacle> obstacle = load_obstacle(obstacle_scene, body);
    if (!obstacle) return failed(obstacle.error());
    body.obstacles.push_back(std::move(*obstacle));
  }
  body.triangles = std::move(mesh.triangles);
  body.typical_force = typical_force(body.model.params.fabric);
  body.build_seconds = timer.seconds();
  if (scene.device == Device::kGpu && loading.purpose == Purpose::kSimulate)
    if (const Status uploaded = upload_to_gpu(body); !uploaded) return failed(uploaded.error());
  return body;
}

void make_rest_surface(const Exec&, ClothBody& body) {
  TURGOR_CHECK(all_indices(body.model.model_vertex, body.model.x_rest.size()),
               "vertices of the mesh are vertices of the model");
  body.rest.clear();
  for (const int v : body.model.model_vertex) body.rest.emplace_back(body.model.x_rest[std::size_t(v)]);
}

Status begin_body(const Exec&, ClothBody& body, const ClothScene& scene, const World& world) {
  for (const int t : body.tool_indices) {
    TURGOR_CHECK(is_index(t, world.tools.size()), "a body is touched by tools of its world");
    const TouchingTool& tool = world.tools[std::size_t(t)];
    // reject forceps
    if (tool.forceps)
      return Error{
          fmt::format("{}: {}: forceps do not grasp cloth: give the tool another shape, and grasp "
                      "the cloth with a hold that has a ball",
                      scene.source_location, tool.name)};
    // register the tool at its initial pose
    body.tools.push_back(tool.tool);
    body.poses.push_back(command_at(tool, 0).pose);
  }
  body.forces.resize(body.tools.size());
  return Done{};
}

}  // namespace turgor
